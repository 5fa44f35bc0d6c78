#include "pipeline/check.hpp"

#include <algorithm>
#include <map>

#include "adjustment/cloud_surface.hpp"
#include "adjustment/robust.hpp"
#include "pipeline/check_cloud.hpp"
#include "pipeline/check_evidence.hpp"
#include "pipeline/check_records.hpp"
#include "pipeline/check_tables.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using Ground = std::map<survey::FrameId, double>;

// Median height of the tie points each frame sees.
Ground ground_by_ties(const survey::Survey& survey) {
  std::map<survey::FrameId, std::vector<double>> heights;
  for (const auto& tie : survey.ties)
    for (const auto& seen : tie.observations) heights[seen.frame].push_back(tie.p_world.z());
  Ground ground;
  constexpr std::size_t kLeast = 5;
  for (auto& [id, z] : heights)
    if (z.size() >= kLeast) ground[id] = adjustment::median(std::move(z));
  return ground;
}

// Height of the cloud below each camera; its median height for cameras beside it.
Ground ground_by_cloud(const survey::Survey& survey, const geometry::PointCloud& cloud) {
  constexpr std::size_t kCells = 250'000;
  const auto surface = adjustment::cloud_surface(cloud, 0.0, 3, kCells);
  std::vector<double> heights;
  for (const float v : surface.up_m.values)
    if (!std::isnan(v)) heights.push_back(static_cast<double>(v));
  const double middle = adjustment::median(std::move(heights));
  Ground ground;
  for (const auto& frame : survey.frames)
    ground[frame.id] = surface.height_at(frame.T_world_camera.translation.head<2>()).value_or(middle);
  return ground;
}

}  // namespace

io::Json CheckResult::to_json() const {
  return io::Json::object({{"ok", ok}, {"findings", pipeline::to_json(findings)}, {"evidence", evidence}});
}

CheckResult check_survey(const fs::path& folder, const CheckOptions& options, base::RunContext& ctx) {
  auto checked_options = options;
  base::validate(base::bind_options(checked_options), "check");
  std::error_code code;
  if (!fs::is_directory(folder, code))
    throw base::Error(base::ErrorCode::not_found, "no such survey folder")
        .file(folder.string())
        .hint("Make one with cairn import");
  Findings findings;
  CheckResult result;
  result.evidence = io::Json::object();
  const auto checked = read_for_check(folder, findings);
  check_records(checked, folder, options, findings, result.evidence);
  const auto images = check_images(checked, folder, findings, result.evidence);
  ctx.check_stop();

  const std::size_t errors_before = findings.count(Severity::error);
  // Proved, or shown to be wrong: either way tie points have said what there is to say.
  const bool decided = check_ties(checked, folder, options, findings, result.evidence) ||
                       findings.count(Severity::error) > errors_before;
  Ground ground = ground_by_ties(checked.survey);
  std::string ground_by = ground.empty() ? "" : "tie_points";
  const std::size_t errors_before_cloud = findings.count(Severity::error);
  const auto cloud = check_cloud(checked, folder, options, findings, result.evidence);
  const std::size_t cloud_errors = findings.count(Severity::error) - errors_before_cloud;
  if (ground.empty() && cloud) {
    ground = ground_by_cloud(checked.survey, cloud->cloud);
    ground_by = "cloud";
  }
  ctx.check_stop();
  // Matching is dear: only where tie points leave the poses open.
  if (!decided && options.pixels && images.size() >= 2) {
    ctx.info("matching " + std::to_string(images.size()) + " images");
    const bool had_ground = !ground.empty();
    check_pairs(checked, folder, images, options, ctx, findings, result.evidence, ground);
    if (!had_ground && !ground.empty()) ground_by = "image_pairs";
  }
  check_heights(checked, folder, ground, ground_by, options, findings, result.evidence);
  // Poses that are wrong say nothing about the cloud.
  if (cloud && findings.count(Severity::error) == errors_before + cloud_errors)
    check_cloud_evidence(checked, *cloud, images, options, ctx, findings, result.evidence);

  result.ok = findings.count(Severity::error) == 0;
  result.findings = findings.list();
  return result;
}

}  // namespace cairn::pipeline
