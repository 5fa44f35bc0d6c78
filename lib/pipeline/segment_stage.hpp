// Stage `segment`: located targets + cloud -> labelled cloud.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "geometry/point_cloud.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"
#include "segmentation/rock_cut.hpp"
#include "survey/target.hpp"

namespace cairn::pipeline {

struct SegmentOptions {
  std::string classes = "boulder,rock";  // target classes that are rocks, comma-separated
  // all: every point of the cloud; labelled: only those with a label (near a rock).
  std::string keep = "all";
  segmentation::RockCutOptions cut;

  void visit(base::OptionVisitor& visitor);
};

// The targets to cut: of a rock class and not deregistered.
[[nodiscard]] std::vector<segmentation::RockTarget> rock_targets(const std::vector<survey::Target>& targets,
                                                                 const SegmentOptions& options);

struct Segmented {
  geometry::PointCloud cloud;     // with columns label and target_id
  std::vector<std::size_t> kept;  // index of each of its points in the cloud given
  segmentation::RockCuts cuts;    // over the cloud given
  Outcome outcome;
};
// `local`: positions in the targets' frame. The cloud keeps its own positions.
[[nodiscard]] Segmented segment_cloud(geometry::PointCloud cloud, const std::vector<geometry::Vec3>& local,
                                      const std::vector<survey::Target>& targets, const SegmentOptions& options,
                                      base::RunContext& ctx);

// segments.json: what became of each target: {"schema_version", "segments": [{id, class, rejected, reasons, message,
// point_count, point_spacing_m, height_m, threshold_m, ground_noise_m, ground_up_m, ground_slope, flanks_seen_share,
// contact_observed_share, contact: [{position_m, status}], notes}]}.
[[nodiscard]] io::Json segments_json(const segmentation::RockCuts& cuts,
                                     const std::vector<segmentation::RockTarget>& targets);

// `cairn segment`: any cloud file. Where targets.json stands in a frame and the cloud declares a CRS, the cloud is
// taken into that frame to be cut; the file written keeps the cloud's own coordinates and records.
struct SegmentFiles {
  std::filesystem::path cloud, targets;
  std::filesystem::path survey;  // "" = none; else its T_world_source and CRS of the cloud count
};
[[nodiscard]] Outcome segment_file(const SegmentFiles& in, const std::filesystem::path& out_las,
                                   const SegmentOptions& options, base::RunContext& ctx);

// The recipe's stage: survey cloud + targets.json -> labelled.las (local frame), segments.json.
[[nodiscard]] std::unique_ptr<Stage> make_segment_stage();

}  // namespace cairn::pipeline
