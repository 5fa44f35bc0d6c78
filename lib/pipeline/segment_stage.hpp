// Stage `segment`: located targets + cloud -> labelled cloud.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "geometry/point_cloud.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"
#include "segmentation/segment_rocks.hpp"
#include "survey/target.hpp"

namespace cairn::pipeline {

struct SegmentOptions {
  std::string classes = "boulder,rock";  // target classes that are rocks, comma-separated
  // all: every point of the cloud; labelled: only those with a label (near a rock).
  std::string keep = "all";
  // Also writes the convention of other tools into `intensity`: 1 rock, 2 basal contact, 0 pedestal and all else.
  bool intensity_labels = false;
  // Edge of a tile, m: LAS clouds without targets, picks and contacts are read, segmented and written tile by tile, so
  // that they need not fit into memory. 0: the whole cloud at once, unless --memory-limit forbids it.
  double tile_m = 0.0;
  segmentation::SegmentRocksOptions rocks;

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
// The same for targets already chosen, with a person's word on them.
[[nodiscard]] Segmented segment_targets(geometry::PointCloud cloud, const std::vector<geometry::Vec3>& local,
                                        const std::vector<segmentation::RockTarget>& targets,
                                        const segmentation::RockGuidance& guidance, const SegmentOptions& options,
                                        base::RunContext& ctx);

// Picks: a table x,y,z,rock (1 rock, 0 not), in the coordinates `to_local` takes.
[[nodiscard]] std::vector<segmentation::RockPick> read_picks(const std::filesystem::path& path);

// segments.json: what became of each target: {"schema_version", "segments": [{id, class, rejected, reasons, message,
// method, point_count, point_spacing_m, noise_m, height_m, threshold_m, ground_noise_m, ground_up_m, ground_slope,
// sides_seen_share, contact_observed_share, contact: [{pad, order, position_m, status, sigma_m}], notes}]}.
[[nodiscard]] io::Json segments_json(const segmentation::RockCuts& cuts,
                                     const std::vector<segmentation::RockTarget>& targets);

// `cairn segment`: any cloud file. Where targets.json stands in a frame and the cloud declares a CRS, the cloud is
// taken into that frame to be cut; the file written keeps the cloud's own coordinates and records.
struct SegmentFiles {
  std::filesystem::path cloud, targets;  // targets "" = every rock that stands out of the ground is looked for
  std::filesystem::path survey;          // "" = none; else its T_world_source and CRS of the cloud count
  std::filesystem::path picks, contact;  // "" = none; in the cloud's coordinates
};
// Beside X.las stands X.contact.csv (contact_beside(out)): the contact lines in the cloud's coordinates. It is written
// to `out_contact`.
[[nodiscard]] std::filesystem::path contact_beside(const std::filesystem::path& labelled);
[[nodiscard]] Outcome segment_file(const SegmentFiles& in, const std::filesystem::path& out_las,
                                   const std::filesystem::path& out_contact, const SegmentOptions& options,
                                   base::RunContext& ctx);

// The recipe's stage: survey cloud + targets.json -> labelled.las (local frame), segments.json, contact.csv.
[[nodiscard]] std::unique_ptr<Stage> make_segment_stage();

}  // namespace cairn::pipeline
