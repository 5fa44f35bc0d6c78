// `cairn segment` without targets on LAS clouds that do not fit into memory.
#pragma once

#include <filesystem>
#include <functional>

#include "pipeline/outcome.hpp"
#include "pipeline/segment_stage.hpp"

namespace cairn::pipeline {

// Whether segment_file goes by tile: a LAS file without targets, picks or contacts, of which all points are written,
// and either a tile was asked for or the whole would pass the memory limit.
[[nodiscard]] bool goes_by_tile(const SegmentFiles& in, const SegmentOptions& options, const base::RunContext& ctx);

// The objects of segment_tiles, each segmented by segment_rocks on its own patch; out_las keeps everything of the file.
// forth: from the file's coordinates to a local frame in metres. Adds tiles, tile_m and buffer_m to the summary.
// Other than over the whole cloud, a rock does not know the circles of its neighbours.
struct LargeSegments {
  segmentation::RockCuts cuts;  // rocks and rejects; no labels a point
  std::vector<segmentation::RockTarget> targets;
  Outcome outcome;
};
[[nodiscard]] LargeSegments segment_large(const SegmentFiles& in, const std::filesystem::path& out_las,
                                          const std::function<geometry::Vec3(const geometry::Vec3&)>& forth,
                                          const SegmentOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
