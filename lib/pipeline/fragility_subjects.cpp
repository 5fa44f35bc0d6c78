#include "pipeline/fragility_subjects.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "fragility/contact_line.hpp"
#include "geometry/least_rectangle.hpp"
#include "io/gaps_json.hpp"
#include "io/mesh.hpp"
#include "io/ply.hpp"
#include "io/rocks_json.hpp"
#include "surface/rock_body.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;

// The outline of points in plan as one closed pad, nothing of it observed; each corner at the height of its point.
survey::Contact assumed_pad(const std::vector<Vec3>& points) {
  survey::Contact contact;
  if (points.empty()) return contact;
  const Vec3 origin = points.front();
  std::vector<Vec2> plan;
  for (const auto& p : points) plan.push_back((p - origin).head<2>());
  for (const auto& corner : geometry::convex_hull(plan)) {
    std::size_t found = 0;
    while (plan[found] != corner) ++found;
    contact.push_back({0, static_cast<std::int64_t>(contact.size()), points[found], false, true, 0.0});
  }
  return contact;
}

survey::ContactVertex vertex_of(const io::Json& json, std::int64_t index) {
  survey::ContactVertex v;
  const auto integer = [&](std::string_view key, std::int64_t otherwise) {
    const auto* found = json.find(key);
    return found == nullptr ? otherwise : found->as_integer();
  };
  v.pad = integer("pad", 0);
  v.order = integer("order", index);
  v.position = json.at("position_m").as_vec3();
  const auto& status = json.at("status").as_string();
  if (status != "observed" && status != "inferred")
    throw Error(ErrorCode::invalid_input, "unknown status of a contact vertex")
        .found("'" + status + "'")
        .allowed("observed, inferred");
  v.observed = status == "observed";
  if (const auto* sigma = json.find("sigma_m"); sigma != nullptr && !sigma->is_null()) v.sigma_m = sigma->as_real();
  if (!(v.sigma_m >= 0.0)) throw Error(ErrorCode::invalid_input, "sigma_m of a contact vertex is negative");
  if (const auto* closed = json.find("closed")) v.closed = closed->as_bool();
  return v;
}

survey::Contact contact_of(const io::Json& json) {
  survey::Contact contact;
  if (const auto* line = json.find("line"); line != nullptr && !line->is_null()) {
    for (const auto& vertex : line->as_array())
      contact.push_back(vertex_of(vertex, static_cast<std::int64_t>(contact.size())));
    fragility::sort_contact(contact);
    return contact;
  }
  // Records without a line: points of an assumed base, in any order.
  std::vector<Vec3> points;
  for (const auto& point : json.at("points").as_array()) points.push_back(point.at("position_m").as_vec3());
  return assumed_pad(points);
}

// A number of the surface stage that may stand in the rock's record or beside it.
double number_beside(const io::Json& surface, std::string_view group, std::string_view key) {
  const io::Json* at = group.empty() ? &surface : surface.find(group);
  if (at == nullptr || !at->is_object()) return 0.0;
  const auto* found = at->find(key);
  return found == nullptr || found->is_null() ? 0.0 : found->as_real();
}

void check_same_mesh(const FragilitySubject& s, const fs::path& mesh) {
  const auto mass = geometry::mass_properties(*s.mesh);
  constexpr double kSame = 1e-6;
  if (std::abs(mass.volume - s.rock.mass->volume) <= kSame * s.rock.mass->volume) return;
  throw Error(ErrorCode::failed_precondition, "the mesh is not the one its record describes")
      .file(mesh.string())
      .found("volume " + base::to_text(mass.volume) + " m3")
      .allowed(base::to_text(s.rock.mass->volume) + " m3")
      .hint("Run cairn surface again");
}

}  // namespace

fragility::Subject FragilitySubject::for_assessment() const {
  fragility::Subject s;
  s.mesh = &*mesh;
  s.mass = *rock.mass;
  s.contact = contact;
  s.evidence = evidence;
  s.noise_m = rock.noise_m;
  s.cap_height_sigma_m = rock.cap_height_sigma_m;
  s.density_kg_m3 = rock.density_kg_m3;
  return s;
}

FragilitySubject subject_of_mesh(const fs::path& path, const fragility::FragilityOptions& options) {
  FragilitySubject s;
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
  std::vector<Vec2> plan;
  for (const auto& v : body.mesh.vertices) plan.push_back(v.head<2>());
  const auto rectangle = geometry::least_area_rectangle(plan);
  const auto box = body.mesh.bounds();
  s.rock.size_m = {rectangle.length, rectangle.width, box.size().z()};
  s.rock.length_azimuth_deg = rectangle.length_azimuth_deg;
  s.rock.base_height_m = box.min.z();
  s.rock.mass = body.mass;
  s.rock.hull_volume_m3 = body.hull_volume;
  s.rock.unseen_area_fraction = body.quality.unseen_area_fraction;
  s.rock.reasons = body.notes;
  s.rock.cap = body.cap;
  s.rock.cap_height_sigma_m = body.cap_height_sigma;
  // What closed a hole was seen by nobody; of the rest a bare mesh says nothing.
  if (body.quality.unseen_area_fraction > 0.0) s.evidence.unseen_area_fraction = body.quality.unseen_area_fraction;
  s.contact = body.contact.empty() ? assumed_pad(fragility::contact_band(body.mesh, options.contact_band))
                                   : std::move(body.contact);
  s.evidence.width_m = rectangle.width;
  s.evidence.height_m = box.size().z();
  s.mesh = std::move(body.mesh);
  return s;
}

FragilitySubject subject_of_record(const fs::path& record) {
  const auto json = io::read_json(record);
  FragilitySubject s;
  s.stem = record.stem().string();
  try {
    s.rock = io::rock_from_json(json.at("rock"));
    if (const auto* frame = json.find("frame"); frame != nullptr && frame->is_string())
      s.north = frame->as_string().rfind("local ENU", 0) == 0 ? "true north" : "+y of the cloud";
    if (s.rock.rejected || !s.rock.mass) return s;
    const auto& surface = json.at("surface");
    s.contact = contact_of(json.at("contact"));
    s.evidence.contact_assumed = json.at("contact").at("assumed").as_bool();
    s.evidence.contact_observed_share = fragility::observed_share(s.contact);
    s.evidence.sides_seen_share = surface.at("sides_seen_share").as_real();
    if (!(s.rock.noise_m > 0.0)) s.rock.noise_m = number_beside(surface, "", "noise_m");
    if (!(s.rock.cap_height_sigma_m > 0.0)) s.rock.cap_height_sigma_m = number_beside(surface, "cap", "h_c_m");
  } catch (Error& error) {
    error.default_file(record.string());
    throw;
  }
  s.evidence.points = s.rock.point_count;
  s.evidence.point_spacing_m = s.rock.point_spacing_m;
  s.evidence.width_m = s.rock.size_m.y();
  s.evidence.height_m = s.rock.size_m.z();
  s.evidence.unseen_area_fraction = s.rock.unseen_area_fraction;
  const auto mesh = fs::path(record).replace_extension(".ply");
  s.mesh = io::read_ply_mesh(mesh).mesh;
  check_same_mesh(s, mesh);
  return s;
}

std::vector<FragilitySubject> subjects_of_folder(const fs::path& folder) {
  std::map<std::int64_t, fs::path> records;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".json")
      if (const auto id = base::parse_integer(entry.path().stem().string())) records[*id] = entry.path();
  std::vector<FragilitySubject> subjects;
  for (const auto& [id, path] : records) subjects.push_back(subject_of_record(path));
  return subjects;
}

std::optional<base::Reject> take_contact(FragilitySubject& s, const io::ContactFile& file, bool single) {
  survey::Contact line;
  for (const auto& row : file.rows)
    if (single || row.rock_id == s.rock.target.value) line.push_back(row.vertex);
  if (line.empty()) return std::nullopt;
  fragility::sort_contact(line);
  const double margin = 0.1 * s.mesh->bounds().size().norm();
  if (const auto outside = fragility::outside_count(line, s.mesh->bounds(), margin); outside > 0)
    return base::Reject{"rock " + s.stem, "contact_outside_rock",
                        std::to_string(outside) + " of " + std::to_string(line.size()) +
                            " contact points lie more than " + base::to_fixed(margin, 2) + " m outside the rock"};
  s.contact = std::move(line);
  s.evidence.contact_assumed = false;
  s.evidence.contact_observed_share = fragility::observed_share(s.contact);
  return std::nullopt;
}

void take_coverage(FragilitySubject& s, const std::vector<survey::CoverageGap>& gaps) {
  if (s.contact.empty()) return;
  constexpr std::size_t kPoints = 200;  // along a pad
  double length = 0.0;
  for (const auto& pad : fragility::pads_of(s.contact)) {
    double of_pad = 0.0;
    (void)fragility::arc_lengths(s.contact, pad, of_pad);
    length += of_pad;
  }
  const auto line = fragility::densified(s.contact, std::max(length / kPoints, 1e-6), kPoints);
  std::size_t covered = 0;
  for (const auto& v : line) {
    const Vec2 at = v.position.head<2>();
    const bool in_gap = std::any_of(gaps.begin(), gaps.end(), [&](const survey::CoverageGap& gap) {
      std::size_t rings = 0;  // even-odd over outline and holes
      for (const auto& ring : gap.rings) rings += geometry::contains(ring, at) ? 1U : 0U;
      return rings % 2 == 1;
    });
    if (!in_gap) ++covered;
  }
  s.evidence.contact_covered_share = static_cast<double>(covered) / static_cast<double>(line.size());
}

std::vector<survey::CoverageGap> read_coverage_gaps(const fs::path& path) {
  const fs::path file = fs::is_directory(path) ? path / "gaps.json" : path;
  if (!fs::exists(file))
    throw Error(ErrorCode::not_found, "no coverage audit there")
        .file(file.string())
        .allowed("a folder of cairn coverage, or its gaps.json");
  return io::read_gaps(file).gaps;
}

}  // namespace cairn::pipeline
