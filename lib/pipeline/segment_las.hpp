// A LAS file segmented by tile: points are read, labelled and written in pieces.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "pipeline/segment_tiles.hpp"

namespace cairn::pipeline {

// Writes `out`: `in` with the dimensions label (u8), target_id (u32) and probability (f32), straight to that path.
// to_local: takes positions from the file's coordinates into metres of a local frame, in place; empty: they are.
// Probability of terrain and of points without a label: 1 and 0.
// Memory: that of segment_tiles, and 16 bytes a labelled point. Cost linear.
[[nodiscard]] TiledSegments segment_las_by_tiles(const std::filesystem::path& in, const std::filesystem::path& out,
                                                 const SegmentTilesOptions& options, const LabelObject& label,
                                                 const std::function<void(std::vector<geometry::Vec3>&)>& to_local,
                                                 base::RunContext& ctx);

}  // namespace cairn::pipeline
