// Stage `terrain`: the survey's cloud -> surface and ground model.
#pragma once

#include <filesystem>
#include <memory>

#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"
#include "segmentation/terrain.hpp"

namespace cairn::pipeline {

struct TerrainInputs {
  std::filesystem::path survey;  // survey folder with a cloud
};

// Writes into `out`:
//   surface.tif  Cloud-Optimised GeoTIFF in the local frame's CRS, float bands `surface` and `ground` [m, heights in
//   the
//                survey's datum], `observed` (1 from points, 0 interpolated) and `points` (in the cell)
//   surface.ply  the surface as a mesh, local ENU
// Cost: linear in points and cells.
[[nodiscard]] Outcome terrain_stage(const TerrainInputs& in, const std::filesystem::path& out,
                                    const segmentation::TerrainOptions& options, base::RunContext& ctx);

// The recipe's stage `terrain`.
[[nodiscard]] std::unique_ptr<Stage> make_terrain_stage();

}  // namespace cairn::pipeline
