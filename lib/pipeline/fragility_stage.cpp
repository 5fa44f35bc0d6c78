#include "pipeline/fragility_stage.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/angle.hpp"
#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "fragility/contact_line.hpp"
#include "fragility/polar_plot.hpp"
#include "geometry/least_rectangle.hpp"
#include "io/contact_csv.hpp"
#include "io/mesh.hpp"
#include "io/ply.hpp"
#include "io/rocks_json.hpp"
#include "io/survey_folder.hpp"
#include "surface/rock_body.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec3;

// One rock before its assessment.
struct Subject {
  std::string stem;  // of its files
  survey::Rock rock;
  std::optional<geometry::TriangleMesh> mesh;  // empty where the rock was rejected before
  std::vector<Vec3> contact;
  fragility::Evidence evidence;
  std::string refusal = "the rock has no closed surface";
};

Subject subject_of_mesh(const fs::path& path, const fragility::FragilityOptions& options) {
  Subject s;
  s.stem = path.stem().string();
  s.rock.target = survey::TargetId(0);
  s.rock.object_class = "rock";
  auto built = surface::body_of(io::read_mesh(path).mesh);
  if (const auto* why = std::get_if<base::Reject>(&built)) {
    s.rock.rejected = true;
    s.rock.reasons = {why->reason};
    s.refusal = why->message;
    return s;
  }
  auto& body = std::get<surface::RockBody>(built);
  std::vector<geometry::Vec2> plan;
  for (const auto& v : body.mesh.vertices) plan.push_back(v.head<2>());
  const auto rectangle = geometry::least_area_rectangle(plan);
  const auto box = body.mesh.bounds();
  s.rock.size_m = {rectangle.length, rectangle.width, box.size().z()};
  s.rock.length_azimuth_deg = rectangle.length_azimuth_deg;
  s.rock.base_height_m = box.min.z();
  s.rock.mass = body.mass;
  s.rock.hull_volume_m3 = body.hull_volume;
  s.rock.unseen_area_fraction = 0.0;
  s.rock.reasons = body.notes;
  s.contact = fragility::contact_band(body.mesh, options.contact_band);
  s.evidence.width_m = rectangle.width;
  s.evidence.height_m = box.size().z();
  s.mesh = std::move(body.mesh);
  return s;
}

Subject subject_of_record(const fs::path& record) {
  const auto json = io::read_json(record);
  Subject s;
  s.stem = record.stem().string();
  try {
    s.rock = io::rock_from_json(json.at("rock"));
    if (s.rock.rejected || !s.rock.mass) return s;
    const auto& surface = json.at("surface");
    for (const auto& point : json.at("contact").at("points").as_array())
      s.contact.push_back(point.at("position_m").as_vec3());
    s.evidence.contact_assumed = json.at("contact").at("assumed").as_bool();
    s.evidence.contact_observed_share = surface.at("contact_observed_share").as_real();
    s.evidence.sides_seen_share = surface.at("sides_seen_share").as_real();
  } catch (Error& error) {
    error.default_file(record.string());
    throw;
  }
  s.evidence.points = s.rock.point_count;
  s.evidence.point_spacing_m = s.rock.point_spacing_m;
  s.evidence.width_m = s.rock.size_m.y();
  s.evidence.height_m = s.rock.size_m.z();
  s.evidence.unseen_area_fraction = s.rock.unseen_area_fraction;
  s.mesh = io::read_ply_mesh(fs::path(record).replace_extension(".ply")).mesh;
  // The record's figures must be those of the mesh beside it.
  const auto mass = geometry::mass_properties(*s.mesh);
  constexpr double kSame = 1e-6;
  if (!(std::abs(mass.volume - s.rock.mass->volume) <= kSame * s.rock.mass->volume))
    throw Error(ErrorCode::failed_precondition, "the mesh is not the one its record describes")
        .file(fs::path(record).replace_extension(".ply").string())
        .found("volume " + base::to_text(mass.volume) + " m3")
        .allowed(base::to_text(s.rock.mass->volume) + " m3")
        .hint("Run cairn surface again");
  return s;
}

// Records of a surface folder in order of id.
std::vector<Subject> subjects_of_folder(const fs::path& folder) {
  std::map<std::int64_t, fs::path> records;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".json")
      if (const auto id = base::parse_integer(entry.path().stem().string())) records[*id] = entry.path();
  std::vector<Subject> subjects;
  for (const auto& [id, path] : records) subjects.push_back(subject_of_record(path));
  return subjects;
}

// Replaces the assumed contact by the digitised one; the reject where that lies elsewhere.
std::optional<base::Reject> take_contact(Subject& s, const io::ContactFile& file, bool single) {
  std::vector<fragility::ContactVertex> line;
  for (const auto& row : file.rows)
    if (single || row.rock_id == s.rock.target.value) line.push_back(row.vertex);
  if (line.empty()) return std::nullopt;
  fragility::sort_contact(line);
  const double margin = 0.1 * s.mesh->bounds().size().norm();
  if (const auto outside = fragility::outside_count(line, s.mesh->bounds(), margin); outside > 0)
    return base::Reject{"rock " + s.stem, "contact_outside_rock",
                        std::to_string(outside) + " of " + std::to_string(line.size()) +
                            " contact points lie more than " + base::to_fixed(margin, 2) + " m outside the rock"};
  s.contact.clear();
  for (const auto& vertex : line) s.contact.push_back(vertex.position);
  s.evidence.contact_assumed = false;
  s.evidence.contact_observed_share = fragility::observed_share(line);
  return std::nullopt;
}

io::Json matrix_json(const geometry::Mat3& m) {
  io::Json rows = io::Json::array();
  for (int r = 0; r < 3; ++r) rows.push(std::vector<double>{m(r, 0), m(r, 1), m(r, 2)});
  return rows;
}

io::Json points_json(const std::vector<Vec3>& points) {
  io::Json list = io::Json::array();
  for (const auto& p : points) list.push(io::Json(p));
  return list;
}

io::Json rock_summary(const Subject& s, const fragility::Assessment& assessment) {
  const auto& mass = *s.rock.mass;
  const double density = s.rock.density_kg_m3;
  const auto& tip = assessment.tipping;
  auto json = io::Json::object({{"id", s.rock.target.value},
                                {"name", s.stem},
                                {"grade", survey::name_of(tip.grade)},
                                {"reasons", io::Json(tip.reasons)},
                                {"volume_m3", mass.volume},
                                {"hull_volume_m3", s.rock.hull_volume_m3},
                                {"density_kg_m3", density},
                                {"density_assumed", s.rock.density_assumed},
                                {"mass_kg", density * mass.volume},
                                {"com_m", io::Json(mass.centre_of_mass)},
                                {"inertia_kg_m2", matrix_json(density * mass.inertia_per_density)},
                                {"contact", points_json(tip.contact)},
                                {"contact_assumed", tip.contact_assumed}});
  if (!tip.critical) return json;
  const auto& edge = assessment.detail.edges[*assessment.detail.critical];
  json.set("alpha_min_deg", base::rad_to_deg(edge.alpha));
  json.set("azimuth_deg", edge.azimuth_deg);
  json.set("topple_toward_deg", edge.azimuth_deg);
  json.set("r_m", edge.r);
  json.set("p_rad_s", edge.p);
  json.set("a_qs_g", edge.a_qs_g);
  json.set("v_min_m_s", edge.v_min);
  json.set("barrier_j", edge.barrier_per_mass * density * mass.volume);
  json.set("a_qs_g_by_azimuth", tip.a_qs_g_by_azimuth);
  return json;
}

io::Json detail_json(const Subject& s, const fragility::Assessment& assessment) {
  const auto& detail = assessment.detail;
  const double mass = s.rock.density_kg_m3 * s.rock.mass->volume;
  io::Json edges = io::Json::array();
  for (const auto& e : detail.edges)
    edges.push(io::Json::object({{"ends_m", points_json({e.ends[0], e.ends[1]})},
                                 {"topple_toward_deg", e.azimuth_deg},
                                 {"inclination_deg", base::rad_to_deg(e.inclination)},
                                 {"alpha_deg", base::rad_to_deg(e.alpha)},
                                 {"r_m", e.r},
                                 {"inertia_kg_m2", e.inertia_per_mass * mass},
                                 {"p_rad_s", e.p},
                                 {"a_qs_g", e.a_qs_g},
                                 {"v_min_m_s", e.v_min},
                                 {"barrier_j", e.barrier_per_mass * mass}}));
  return io::Json::object({{"schema_version", 1},
                           {"id", s.rock.target.value},
                           {"grade", survey::name_of(assessment.tipping.grade)},
                           {"reasons", io::Json(assessment.tipping.reasons)},
                           {"definition", "edge: rotation about an edge of the hull of the contact"},
                           {"critical_edge", static_cast<std::int64_t>(*detail.critical)},
                           {"edges", std::move(edges)},
                           {"plumb_margin_m", detail.plumb_margin},
                           {"alpha_point_deg", base::rad_to_deg(detail.alpha_point)},
                           {"a_qs_min_g", detail.a_qs_min_g},
                           {"a_qs_min_toward_deg", detail.a_qs_min_azimuth_deg},
                           {"a_qs_g_by_azimuth", detail.a_qs_g_by_azimuth}});
}

struct Assessed {
  std::vector<survey::Rock> rocks;
  io::Json rows = io::Json::array();
  std::map<std::string, std::int64_t> grades;
  std::vector<base::Reject> rejects;
};

Assessed assess_all(std::vector<Subject> subjects, const std::optional<io::ContactFile>& contact, const fs::path& plots,
                    bool density_assumed, const fragility::FragilityOptions& options, base::RunContext& ctx) {
  Assessed all;
  std::uint64_t done = 0;
  const bool single = subjects.size() == 1;
  const auto refuse = [&all](Subject& s, base::Reject why) {
    s.rock.rejected = true;
    s.rock.reasons = {why.reason};
    s.rock.tipping = {};
    s.rock.tipping.reasons = {why.reason};
    all.rejects.push_back(std::move(why));
    ++all.grades[std::string(survey::name_of(s.rock.tipping.grade))];
    all.rocks.push_back(std::move(s.rock));
  };
  for (auto& s : subjects) {
    ctx.check_stop();
    ctx.progress("rocks", ++done, subjects.size());
    s.rock.density_kg_m3 = options.density_kg_m3;
    s.rock.density_assumed = density_assumed;
    if (!s.mesh) {
      const std::string reason = s.rock.reasons.empty() ? "no_surface" : s.rock.reasons.front();
      refuse(s, {"rock " + s.stem, reason, s.refusal});
      continue;
    }
    if (contact)
      if (auto why = take_contact(s, *contact, single)) {
        refuse(s, std::move(*why));
        continue;
      }
    const auto assessment = fragility::assess(*s.rock.mass, s.contact, s.evidence, options);
    s.rock.tipping = assessment.tipping;
    ++all.grades[std::string(survey::name_of(assessment.tipping.grade))];
    all.rows.push(rock_summary(s, assessment));
    if (assessment.tipping.critical) {
      base::write_file(plots / (s.stem + "_tipping.json"), detail_json(s, assessment).dump() + "\n");
      base::write_file(plots / (s.stem + "_tipping.svg"),
                       fragility::polar_plot_svg(assessment.tipping, s.rock.object_class + " " + s.stem));
    }
    all.rocks.push_back(std::move(s.rock));
  }
  return all;
}

Outcome outcome_of(Assessed& all) {
  io::Json grades = io::Json::object();
  for (const auto& [name, count] : all.grades) grades.set(name, count);
  Outcome outcome;
  outcome.rejects = std::move(all.rejects);
  outcome.summary = io::Json::object({{"assessed", all.rows.size()},
                                      {"rejected", outcome.rejects.size()},
                                      {"rejected_by_reason", count_by_reason(outcome.rejects)},
                                      {"by_grade", std::move(grades)},
                                      {"rocks", std::move(all.rows)}});
  return outcome;
}

class FragilityStage final : public Stage {
 public:
  [[nodiscard]] std::string_view name() const override { return "fragility"; }
  [[nodiscard]] std::vector<std::string> needs() const override { return {"segment", "surface"}; }
  [[nodiscard]] base::VisitOptions options() override { return base::bind_options(options_); }
  [[nodiscard]] Estimate estimate(const StageInputs&) const override { return {std::uint64_t{128} << 20, 16U << 20}; }

  Outcome run(const StageInputs& in, const fs::path& out, base::RunContext& ctx) override {
    base::validate(options(), "fragility");
    const auto survey = io::read_survey(in.survey);
    fs::create_directories(out / "rocks");
    const fs::path folder = in.products / "rocks";
    auto subjects = fs::is_directory(folder) ? subjects_of_folder(folder) : std::vector<Subject>{};
    const bool assumed = options_.density_kg_m3 == fragility::FragilityOptions{}.density_kg_m3;
    auto all = assess_all(std::move(subjects), std::nullopt, out / "rocks", assumed, options_, ctx);
    io::RocksFile file{survey.manifest.origin, all.rocks};
    add_uncut(file, in.products / "segments.json");
    io::write_rocks(out / "rocks.json", file);
    return outcome_of(all);
  }

 private:
  // Targets that were never cut stand in rocks.json too, with their reason.
  void add_uncut(io::RocksFile& file, const fs::path& segments) const {
    const auto json = io::read_json(segments);
    for (const auto& row : json.at("segments").as_array()) {
      if (!row.at("rejected").as_bool()) continue;
      survey::Rock rock;
      rock.target = survey::TargetId(row.at("id").as_integer());
      rock.object_class = row.at("class").as_string();
      rock.rejected = true;
      for (const auto& reason : row.at("reasons").as_array()) rock.reasons.push_back(reason.as_string());
      rock.tipping.reasons = rock.reasons;
      rock.density_kg_m3 = options_.density_kg_m3;
      file.rocks.push_back(std::move(rock));
    }
    std::sort(file.rocks.begin(), file.rocks.end(),
              [](const survey::Rock& a, const survey::Rock& b) { return a.target < b.target; });
  }

  fragility::FragilityOptions options_;
};

}  // namespace

Outcome fragility_files(const FragilityFiles& in, const fs::path& out, bool density_assumed,
                        const fragility::FragilityOptions& options, base::RunContext& ctx) {
  std::optional<io::ContactFile> contact;
  if (!in.contact.empty()) {
    contact = io::read_contact_csv(in.contact);
    if (!contact->crs.empty() && contact->crs != "local")
      throw Error(ErrorCode::crs_mismatch, "the contact is not in the mesh's frame")
          .file(in.contact.string())
          .found(contact->crs)
          .allowed("# crs: local (the frame of the mesh)")
          .hint("Convert the contact line to the mesh's frame");
  }
  if (!fs::exists(in.input)) throw Error(ErrorCode::not_found, "no such mesh or folder").file(in.input.string());
  std::vector<Subject> subjects;
  if (fs::is_directory(in.input)) subjects = subjects_of_folder(in.input);
  else subjects.push_back(subject_of_mesh(in.input, options));
  if (subjects.empty())
    throw Error(ErrorCode::invalid_input, "the folder holds no rock")
        .file(in.input.string())
        .allowed("<id>.json with <id>.ply, as cairn surface writes them");
  const bool single_mesh = !fs::is_directory(in.input);
  auto all = assess_all(std::move(subjects), contact, out, density_assumed, options, ctx);
  if (single_mesh && !all.rejects.empty()) {
    const auto& why = all.rejects.front();
    throw Error(ErrorCode::invalid_input, why.reason == "contact_outside_rock" ? "the contact does not lie at the rock"
                                                                               : "the mesh is not a closed body")
        .file(why.reason == "contact_outside_rock" ? in.contact.string() : in.input.string())
        .found(why.reason + ": " + why.message)
        .allowed("one closed surface, and a contact at its base");
  }
  io::Json list = io::Json::array();
  for (const auto& rock : all.rocks) list.push(io::to_json(rock));
  // Without a survey no frame is known; a made-up origin would place the rocks somewhere.
  const auto records = io::Json::object({{"schema_version", 1}, {"frame", io::Json()}, {"rocks", std::move(list)}});
  base::write_file(out / "rocks.json", records.dump() + "\n");
  return outcome_of(all);
}

std::unique_ptr<Stage> make_fragility_stage() {
  return std::make_unique<FragilityStage>();
}

}  // namespace cairn::pipeline
