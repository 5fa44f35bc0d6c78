#include "pipeline/surface_stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"
#include "geometry/least_rectangle.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
#include "io/glb.hpp"
#include "io/ply.hpp"
#include "io/rocks_json.hpp"
#include "segmentation/contact_line.hpp"
#include "segmentation/rock_cut.hpp"
#include "survey/rock.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;
using segmentation::Label;

// The points of one rock and the terrain around it, with what they say.
struct RockPoints {
  std::int64_t id = 0;
  std::vector<Vec3> points;
  survey::Contact contact;           // given; empty where there is none
  segmentation::GroundPlane ground;  // of the terrain
  segmentation::GroundPlane seat;    // of the contact, else the ground
  segmentation::RockShape shape;
  bool level = false;            // no terrain: the plane is assumed
  bool contact_outside = false;  // a contact was given, elsewhere
};

const geometry::ScalarColumn& column(const geometry::PointCloud& cloud, const std::string& name) {
  if (const auto* found = cloud.scalar(name)) return *found;
  throw Error(ErrorCode::failed_precondition, "the cloud has no column '" + name + "'")
      .hint("Make it with cairn segment");
}

// A contact belongs to a rock where all of it lies within a tenth of the rock's size from the rock's box.
bool near_rock(const survey::Contact& contact, const std::vector<Vec3>& points) {
  geometry::Box3 box;
  for (const auto& p : points) box.extend(p);
  const double margin = 0.1 * box.size().norm();
  return std::all_of(contact.begin(), contact.end(), [&](const survey::ContactVertex& v) {
    return ((v.position - box.min).array() >= -margin).all() && ((box.max - v.position).array() >= -margin).all();
  });
}

// Least-squares plane of the contact line, as far as it is flatter than 45 degrees.
std::optional<segmentation::GroundPlane> plane_of(const survey::Contact& contact) {
  if (contact.size() < 3) return std::nullopt;
  Vec3 middle = Vec3::Zero();
  for (const auto& v : contact) middle += v.position / static_cast<double>(contact.size());
  geometry::Mat2 a = geometry::Mat2::Zero();
  Vec2 b = Vec2::Zero();
  for (const auto& v : contact) {
    const Vec3 d = v.position - middle;
    a += d.head<2>() * d.head<2>().transpose();
    b += d.head<2>() * d.z();
  }
  const double determinant = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
  segmentation::GroundPlane plane;
  plane.centre = middle.head<2>();
  plane.up_at_centre = middle.z();
  if (determinant > 1e-6 * a.trace() * a.trace())
    plane.slope = Vec2(a(1, 1) * b.x() - a(0, 1) * b.y(), a(0, 0) * b.y() - a(1, 0) * b.x()) / determinant;
  if (plane.slope.norm() > 1.0) plane.slope.setZero();
  return plane;
}

RockPoints describe(std::int64_t id, std::vector<Vec3> points, const survey::Contact& contact,
                    const geometry::PointCloud& cloud, const std::vector<std::size_t>& terrain, double ground_width) {
  RockPoints rock;
  rock.id = id;
  rock.points = std::move(points);
  if (near_rock(contact, rock.points)) rock.contact = contact;
  rock.contact_outside = rock.contact.size() != contact.size();
  Vec2 middle = Vec2::Zero();
  for (const auto& p : rock.points) middle += p.head<2>();
  middle /= static_cast<double>(rock.points.size());
  double radius = 0.0, lowest = rock.points.front().z();
  for (const auto& p : rock.points) {
    radius = std::max(radius, (p.head<2>() - middle).norm());
    lowest = std::min(lowest, p.z());
  }
  std::vector<Vec3> around;
  for (const std::size_t i : terrain)
    if ((cloud.positions[i].head<2>() - middle).norm() <= radius + ground_width) around.push_back(cloud.positions[i]);
  const auto ground = segmentation::fit_ground(around, middle);
  const auto seat = plane_of(rock.contact);
  rock.level = !ground.has_value() && !seat.has_value();
  if (ground) rock.ground = *ground;
  else {
    rock.ground.centre = middle;
    rock.ground.up_at_centre = lowest;
  }
  rock.seat = seat ? *seat : rock.ground;
  double threshold = std::numeric_limits<double>::infinity();
  for (const auto& p : rock.points) threshold = std::min(threshold, rock.seat.height_above(p));
  rock.shape = segmentation::describe_rock(rock.points, rock.seat, std::max(0.0, threshold));
  return rock;
}

survey::Rock record_of(const RockPoints& in, const std::string& object_class) {
  survey::Rock rock;
  rock.target = survey::TargetId(in.id);
  rock.object_class = object_class;
  rock.point_count = in.points.size();
  rock.point_spacing_m = in.shape.spacing;
  std::vector<Vec2> plan;
  for (const auto& p : in.points) plan.push_back(p.head<2>());
  const auto rectangle = geometry::least_area_rectangle(plan);
  rock.size_m = {rectangle.length, rectangle.width, in.shape.height};
  rock.length_azimuth_deg = rectangle.length_azimuth_deg;
  rock.base_height_m = in.ground.up_at_centre;
  return rock;
}

// Where the body rests: the contact given; else where it was closed, or for a wrap the seen crease (5.2: never the
// closed mesh).
survey::Contact contact_of(const RockPoints& in, const surface::RockBody& body) {
  if (!in.contact.empty()) return in.contact;
  if (!body.contact.empty()) return body.contact;
  survey::Contact contact;
  const auto add = [&contact](const Vec3& p, bool observed) {
    survey::ContactVertex vertex;
    vertex.order = static_cast<std::int64_t>(contact.size());
    vertex.position = p;
    vertex.observed = observed;
    contact.push_back(vertex);
  };
  if (body.cap == survey::CapModel::wrap) {
    for (const auto& sample : in.shape.contact) add(sample.position, sample.observed);
    return contact;
  }
  std::vector<Vec2> foot;
  constexpr double kOnGround = 1e-6;  // m: the cap's vertices were put on the plane exactly
  for (const auto& v : body.mesh.vertices)
    if (std::abs(in.seat.height_above(v)) < kOnGround) foot.push_back((v - body.mesh.vertices.front()).head<2>());
  for (const auto& p : geometry::convex_hull(foot)) {
    const Vec2 q = p + body.mesh.vertices.front().head<2>();
    add({q.x(), q.y(), in.seat.up(q)}, false);
  }
  return contact;
}

io::Json contact_json(const survey::Contact& contact, bool assumed) {
  io::Json line = io::Json::array();
  for (const auto& v : contact)
    line.push(io::Json::object({{"pad", v.pad},
                                {"order", v.order},
                                {"position_m", io::Json(v.position)},
                                {"status", v.observed ? "observed" : "inferred"},
                                {"sigma_m", v.sigma_m},
                                {"closed", v.closed}}));
  return io::Json::object({{"assumed", assumed}, {"line", std::move(line)}});
}

double observed_share(const survey::Contact& contact) {
  const auto seen = std::count_if(contact.begin(), contact.end(), [](const auto& v) { return v.observed; });
  return contact.empty() ? 0.0 : static_cast<double>(seen) / static_cast<double>(contact.size());
}

// The contact that the labels of the cloud show around one rock; empty where none of its points is labelled as contact.
survey::Contact contact_in_labels(std::int64_t id, const std::vector<Vec3>& rock, const geometry::PointCloud& cloud,
                                  const std::vector<double>& label, const std::vector<double>& target) {
  geometry::Box3 box;
  for (const auto& p : rock) box.extend(p);
  const Vec3 margin = Vec3::Constant(0.25 * box.size().norm());
  std::vector<Vec3> points;
  std::vector<Label> labels;
  bool shown = false;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto& p = cloud.positions[i];
    if (((p - box.min + margin).array() < 0.0).any() || ((box.max + margin - p).array() < 0.0).any()) continue;
    const bool own = target[i] == static_cast<double>(id);
    const auto name = static_cast<Label>(static_cast<std::uint8_t>(label[i]));
    const bool basal = own && name == Label::basal_contact;
    points.push_back(p);
    // What belongs to another rock is surroundings to this one.
    labels.push_back(own || name == Label::terrain ? name : Label::unlabelled);
    shown = shown || basal;
  }
  return shown ? segmentation::contact_from_labels(points, labels) : survey::Contact{};
}

// The mesh in two colours: what points support, and what was made up.
geometry::TriangleMesh coloured(const surface::RockBody& body) {
  constexpr std::array<std::uint8_t, 3> kSeen{168, 150, 126}, kUnseen{196, 96, 70};
  auto mesh = body.mesh;
  mesh.colours.assign(mesh.vertices.size(), kSeen);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (body.seen[t] == 0)
      for (const auto v : mesh.triangles[t]) mesh.colours[v] = kUnseen;
  return mesh;
}

io::Json quality_json(const surface::BodyQuality& q) {
  return io::Json::object({{"watertight", q.watertight},
                           {"open_edges", q.topology.boundary_edges},
                           {"inconsistent_edges", q.topology.inconsistent_edges},
                           {"non_manifold_edges", q.topology.non_manifold_edges},
                           {"components", q.topology.components},
                           {"self_intersecting", q.self_intersecting},
                           {"unseen_area_fraction", q.unseen_area_fraction}});
}

void write_record(const fs::path& path, const std::string& frame, const survey::Rock& rock, io::Json surface,
                  io::Json contact) {
  const auto json = io::Json::object({{"schema_version", 1},
                                      {"frame", frame},
                                      {"rock", io::to_json(rock)},
                                      {"surface", std::move(surface)},
                                      {"contact", std::move(contact)}});
  base::write_file(path, json.dump() + "\n");
}

// Writes the rock's files; the reject where it has no body.
std::optional<base::Reject> write_rock(const RockPoints& in, const std::string& object_class, const std::string& frame,
                                       const fs::path& folder, const SurfaceOptions& options) {
  const std::string stem = std::to_string(in.id);
  survey::Rock rock = record_of(in, object_class);
  const surface::BodyInput input{in.points, [&in](const Vec2& p) { return in.seat.up(p); }, in.shape.spacing,
                                 in.shape.observed_share(), in.contact};
  auto built = surface::build_body(input, options.body);
  if (auto* why = std::get_if<base::Reject>(&built)) {
    why->record = "rock " + stem;
    rock.rejected = true;
    rock.reasons = {why->reason};
    rock.tipping.reasons = {why->reason};
    write_record(folder / (stem + ".json"), frame, rock, io::Json(), io::Json());
    return *why;
  }
  auto& body = std::get<surface::RockBody>(built);
  if (in.level) body.notes.emplace_back("ground_assumed_level");
  if (in.contact_outside) body.notes.emplace_back("contact_outside_rock");
  const auto contact = contact_of(in, body);
  rock.cap = body.cap;
  rock.unseen_area_fraction = body.quality.unseen_area_fraction;
  rock.mass = body.mass;
  rock.hull_volume_m3 = body.hull_volume;
  rock.noise_m = body.noise;
  rock.cap_height_sigma_m = body.cap_height_sigma;
  io::PlyWriteOptions ply;
  ply.comments = {"rock " + stem, frame};
  const auto mesh = coloured(body);
  io::write_ply(folder / (stem + ".ply"), mesh, ply);
  io::GlbWriteOptions glb;
  glb.name = "rock " + stem;
  glb.origin = body.mass.centre_of_mass;
  glb.frame = frame;
  glb.properties = io::Json::object({{"id", in.id},
                                     {"class", object_class},
                                     {"volume_m3", body.mass.volume},
                                     {"unseen_area_fraction", body.quality.unseen_area_fraction}});
  glb.normals = false;
  io::write_glb(folder / (stem + ".glb"), mesh, glb);
  const auto surface = io::Json::object(
      {{"method", body.method},
       {"cap", io::Json::object({{"model", survey::name_of(body.cap)}, {"h_c_m", body.cap_height_sigma}})},
       {"noise_m", body.noise},
       {"surface_spacing_m", body.point_spacing},
       {"quality", quality_json(body.quality)},
       {"sides_seen_share", in.shape.sides_seen_share},
       {"contact_observed_share", in.contact.empty() ? in.shape.observed_share() : observed_share(in.contact)},
       {"ground_up_m", in.ground.up_at_centre},
       {"ground_slope", std::vector<double>{in.ground.slope.x(), in.ground.slope.y()}},
       {"ground_noise_m", in.ground.noise},
       {"notes", io::Json(body.notes)}});
  write_record(folder / (stem + ".json"), frame, rock, surface, contact_json(contact, in.contact.empty()));
  return std::nullopt;
}

void require_metres(const io::CloudFile& file, const fs::path& path) {
  if (file.facts.crs.empty()) return;
  const auto info = geodesy::describe_crs(file.facts.crs);
  if (!info.geographic && info.horizontal_unit_m == 1.0 && (!info.has_vertical || info.vertical_unit_m == 1.0)) return;
  throw Error(ErrorCode::crs_mismatch, "volumes need coordinates in metres")
      .file(path.string())
      .found(info.name)
      .allowed("a projected CRS in metres, or the local frame")
      .hint("Convert the cloud first: cairn convert --crs EPSG:n");
}

// `cloud_crs`: a line in the cloud's own CRS counts too.
RockContacts read_contacts(const fs::path& path, const std::string& cloud_crs) {
  const auto file = io::read_contact_csv(path);
  if (!file.crs.empty() && file.crs != "local" && file.crs != cloud_crs)
    throw Error(ErrorCode::crs_mismatch, "the contact is not in the cloud's frame")
        .file(path.string())
        .found(file.crs)
        .allowed("# crs: local (the coordinates of the cloud)")
        .hint("Convert the contact line to the cloud's frame");
  RockContacts contacts;
  for (const auto& row : file.rows) contacts[row.rock_id].push_back(row.vertex);
  for (auto& [id, line] : contacts)
    std::sort(line.begin(), line.end(),
              [](const auto& a, const auto& b) { return std::tie(a.pad, a.order) < std::tie(b.pad, b.order); });
  return contacts;
}

class SurfaceStage final : public Stage {
 public:
  [[nodiscard]] std::string_view name() const override { return "surface"; }
  [[nodiscard]] std::vector<std::string> needs() const override { return {"segment"}; }
  [[nodiscard]] base::VisitOptions options() override { return base::bind_options(options_); }
  [[nodiscard]] Estimate estimate(const StageInputs&) const override { return {std::uint64_t{256} << 20, 64U << 20}; }

  Outcome run(const StageInputs& in, const fs::path& out, base::RunContext& ctx) override {
    base::validate(options(), "surface");
    const auto file = io::read_cloud(in.products / "labelled.las");
    RockClasses classes;
    const auto segments = io::read_json(in.products / "segments.json");
    for (const auto& row : segments.at("segments").as_array())
      classes[row.at("id").as_integer()] = row.at("class").as_string();
    fs::create_directories(out / "rocks");
    const fs::path lines = in.products / "contact.csv";
    const auto contacts = fs::exists(lines) ? read_contacts(lines, "") : RockContacts{};
    return surface_rocks(file.cloud, classes, contacts, "local ENU [m]: x east, y north, z up", out / "rocks", options_,
                         ctx);
  }

 private:
  SurfaceOptions options_;
};

}  // namespace

void SurfaceOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("ground-width-m", ground_width_m, 0.05, 50.0,
               "terrain points up to this far beyond the rock carry the ground plane");
  body.visit(visitor);
}

Outcome surface_rocks(const geometry::PointCloud& labelled, const RockClasses& classes, const RockContacts& contacts,
                      const std::string& frame_text, const fs::path& folder, const SurfaceOptions& options,
                      base::RunContext& ctx) {
  const auto& label = column(labelled, segmentation::kLabelColumn).values;
  const auto& target = column(labelled, segmentation::kTargetIdColumn).values;
  std::map<std::int64_t, std::vector<Vec3>> rocks;
  std::vector<std::size_t> terrain;
  for (std::size_t i = 0; i < labelled.size(); ++i) {
    if (label[i] == static_cast<double>(Label::terrain)) terrain.push_back(i);
    if (label[i] == static_cast<double>(Label::rock) && target[i] != static_cast<double>(segmentation::kNoTarget))
      rocks[static_cast<std::int64_t>(target[i])].push_back(labelled.positions[i]);
  }
  Outcome outcome;
  io::Json rows = io::Json::array();
  std::map<std::string, std::int64_t> methods;
  double volume = 0.0;
  std::uint64_t done = 0;
  for (auto& [id, points] : rocks) {
    ctx.check_stop();
    ctx.progress("rocks", ++done, rocks.size());
    const auto known = classes.find(id);
    const auto given = contacts.find(id);
    const auto line = given != contacts.end() ? given->second : contact_in_labels(id, points, labelled, label, target);
    const auto rock = describe(id, std::move(points), line, labelled, terrain, options.ground_width_m);
    auto why = write_rock(rock, known == classes.end() ? "rock" : known->second, frame_text, folder, options);
    if (why) {
      outcome.rejects.push_back(std::move(*why));
      continue;
    }
    const auto written = io::read_json(folder / (std::to_string(id) + ".json"));
    const auto& mass = written.at("rock").at("mass");
    volume += mass.at("volume_m3").as_real();
    ++methods[written.at("surface").at("method").as_string()];
    rows.push(io::Json::object({{"id", id},
                                {"method", written.at("surface").at("method")},
                                {"watertight", written.at("surface").at("quality").at("watertight")},
                                {"volume_m3", mass.at("volume_m3")},
                                {"hull_volume_m3", written.at("rock").at("hull_volume_m3")},
                                {"unseen_area_fraction", written.at("rock").at("unseen_area_fraction")}}));
  }
  io::Json by_method = io::Json::object();
  for (const auto& [name, count] : methods) by_method.set(name, count);
  outcome.summary = io::Json::object({{"rocks", rows.size()},
                                      {"rejected", outcome.rejects.size()},
                                      {"rejected_by_reason", count_by_reason(outcome.rejects)},
                                      {"by_method", std::move(by_method)},
                                      {"total_volume_m3", volume},
                                      {"surfaces", std::move(rows)}});
  return outcome;
}

fs::path contact_file(const SurfaceFiles& in) {
  if (!in.contact.empty()) return in.contact;
  const auto beside = fs::path(in.labelled).replace_extension(".contact.csv");
  return fs::exists(beside) ? beside : fs::path();
}

Outcome surface_file(const SurfaceFiles& in, const fs::path& folder, const SurfaceOptions& options,
                     base::RunContext& ctx) {
  const auto file = io::read_cloud(in.labelled);
  for (const auto& warning : file.facts.warnings) ctx.warn(in.labelled.filename().string() + ": " + warning);
  require_metres(file, in.labelled);
  const std::string frame = file.facts.crs.empty() ? "coordinates of the cloud [m], z up"
                                                   : geodesy::describe_crs(file.facts.crs).name + " [m], z up";
  const auto lines = contact_file(in);
  const auto contacts = lines.empty() ? RockContacts{} : read_contacts(lines, file.facts.crs);
  try {
    return surface_rocks(file.cloud, {}, contacts, frame, folder, options, ctx);
  } catch (Error& error) {
    error.default_file(in.labelled.string());
    throw;
  }
}

std::unique_ptr<Stage> make_surface_stage() {
  return std::make_unique<SurfaceStage>();
}

}  // namespace cairn::pipeline
