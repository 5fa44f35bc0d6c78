#include "pipeline/coverage_targets.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "io/contact_csv.hpp"
#include "io/csv.hpp"
#include "io/survey_json.hpp"
#include "io/targets_json.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using coverage::PartAudit;
using coverage::TargetAudit;

void add_contacts(CoverageTargets& targets, const fs::path& path, const std::optional<survey::Origin>& origin) {
  io::ContactFile file = io::read_contact_csv(path);
  std::optional<geodesy::CrsConverter> converter;
  if (!file.crs.empty() && file.crs != "local") {
    if (!origin)
      throw base::Error(base::ErrorCode::crs_mismatch, "the contacts declare a CRS and the views have none")
          .file(path.string())
          .found(file.crs);
    converter.emplace(file.crs, geodesy::LocalFrame(origin->position));
  }
  for (io::ContactRow& row : file.rows) {
    const auto body = std::find_if(targets.bodies.begin(), targets.bodies.end(),
                                   [&](const coverage::TargetBody& b) { return b.id.value == row.rock_id; });
    if (body == targets.bodies.end()) continue;
    if (converter) row.vertex.position = converter->to_local(row.vertex.position);
    body->contact.push_back(row.vertex);
  }
  for (coverage::TargetBody& body : targets.bodies)
    std::stable_sort(body.contact.begin(), body.contact.end(),
                     [](const auto& a, const auto& b) { return a.pad != b.pad ? a.pad < b.pad : a.order < b.order; });
}

// Numbers that do not exist are null.
io::Json number(double value) {
  return std::isfinite(value) ? io::Json(value) : io::Json();
}

io::Json to_json(const PartAudit& part) {
  io::Json by_verdict = io::Json::object();
  for (std::size_t v = 0; v < coverage::kVerdicts; ++v)
    if (part.area_by_verdict[v] > 0.0)
      by_verdict.set(std::string(coverage::name_of(static_cast<coverage::Verdict>(v))), part.area_by_verdict[v]);
  return io::Json::object({{"completeness", part.completeness()},
                           {"area_m2", part.area_m2},
                           {"buried_m2", part.buried_m2},
                           {"area_m2_by_verdict", std::move(by_verdict)},
                           {"views_median", number(part.views_median)},
                           {"gsd_best_mm_median", number(part.gsd_median_mm)},
                           {"incidence_best_deg_median", number(part.incidence_median_deg)}});
}

io::Json by_azimuth(const std::array<double, coverage::kSectors>& values) {
  io::Json list = io::Json::array();
  for (const double v : values) list.push(number(v));
  return list;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

}  // namespace

CoverageTargets read_coverage_targets(const fs::path& targets, const fs::path& contacts,
                                      const std::optional<survey::Origin>& origin) {
  const io::TargetsFile file = io::read_targets(targets);
  if (origin) io::require_same_frame(file.frame, *origin, targets.string());
  CoverageTargets result;
  for (const survey::Target& target : file.targets) {
    if (target.state == survey::TargetState::deregistered) continue;
    if (!target.refined && !target.bcylinder) {
      result.rejects.push_back({"target " + std::to_string(target.id.value), "no_cylinder",
                                "neither a fitted body nor its points say how large it is"});
      continue;
    }
    result.bodies.push_back({target.id, target.refined ? target.refined->cylinder : *target.bcylinder, {}});
  }
  if (!contacts.empty()) add_contacts(result, contacts, origin);
  return result;
}

io::Json to_json(const TargetAudit& target) {
  io::Json reasons = io::Json::array();
  for (const std::string& reason : target.reasons) reasons.push(reason);
  const geometry::VerticalCylinder& c = target.cylinder;
  return io::Json::object(
      {{"target_id", target.id.value},
       {"passed", target.passed},
       {"reasons", std::move(reasons)},
       {"cylinder", io::Json::object({{"east_m", c.axis.x()},
                                      {"north_m", c.axis.y()},
                                      {"bottom_up_m", c.bottom},
                                      {"top_up_m", c.top},
                                      {"radius_m", c.radius}})},
       {"wall", to_json(target.wall)},
       {"top", to_json(target.top)},
       {"basal_band", io::Json::object({{"contact_known", target.basal.contact_known},
                                        {"perimeter_m", target.basal.perimeter_m},
                                        {"seen_share", target.basal.seen_share},
                                        {"no_data_share", target.basal.no_data_share},
                                        {"gsd_best_mm_median", number(target.basal.gsd_best_mm)},
                                        {"seen_by_azimuth", by_azimuth(target.basal.seen_by_azimuth)}})},
       {"azimuth_bins", target.azimuth_bins},
       {"sigma_max_mm_p95", number(target.sigma_95_mm)},
       {"wall_by_azimuth", by_azimuth(target.wall_by_azimuth)}});
}

void write_target_rows(const fs::path& path, const std::vector<TargetAudit>& targets) {
  io::CsvWriter csv(path, {"target_id",
                           "passed",
                           "reasons",
                           "east_m",
                           "north_m",
                           "height_m",
                           "radius_m",
                           "wall_completeness",
                           "wall_area_m2",
                           "wall_buried_m2",
                           "wall_views_median",
                           "wall_gsd_best_mm_median",
                           "wall_incidence_best_deg_median",
                           "top_completeness",
                           "top_area_m2",
                           "basal_contact_known",
                           "basal_perimeter_m",
                           "basal_seen_share",
                           "basal_no_data_share",
                           "basal_gsd_best_mm_median",
                           "azimuth_bins",
                           "sigma_max_mm_p95"});
  for (const TargetAudit& t : targets) {
    csv.cell(t.id.value).cell(t.passed ? "true" : "false").cell(joined(t.reasons));
    csv.cell(t.cylinder.axis.x()).cell(t.cylinder.axis.y()).cell(t.cylinder.height()).cell(t.cylinder.radius);
    csv.cell(t.wall.completeness()).cell(t.wall.area_m2).cell(t.wall.buried_m2).cell(t.wall.views_median);
    csv.cell(t.wall.gsd_median_mm).cell(t.wall.incidence_median_deg).cell(t.top.completeness()).cell(t.top.area_m2);
    csv.cell(t.basal.contact_known ? "true" : "false").cell(t.basal.perimeter_m).cell(t.basal.seen_share);
    csv.cell(t.basal.no_data_share).cell(t.basal.gsd_best_mm).cell(t.azimuth_bins).cell(t.sigma_95_mm);
    csv.end_row();
  }
  csv.finish();
}

}  // namespace cairn::pipeline
