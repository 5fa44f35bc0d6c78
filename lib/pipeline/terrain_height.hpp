// Heights of a terrain raster in the local frame.
#pragma once

#include <filesystem>
#include <optional>

#include "geodesy/local_frame.hpp"
#include "geometry/grid.hpp"
#include "geometry/vec.hpp"

namespace cairn::pipeline {

// Band `ground` of surface.tif (of another raster its first float band), its datum heights turned back into local up. A
// raster in another CRS than the frame's own is resampled, bilinear, into cells of the same size; its heights are taken
// as above the ellipsoid unless its CRS names another datum. Immutable; queries may run from several threads.
class TerrainHeight {
 public:
  // Throws invalid_input where the raster has no band of heights, crs_mismatch where it declares no CRS or one that
  // cannot be used at the frame's place.
  TerrainHeight(const std::filesystem::path& raster, const geodesy::LocalFrame& frame);

  // Up of the cell at (east, north), m; the nearest known cell within 2 m where that one is empty.
  [[nodiscard]] std::optional<double> up(double east, double north) const;

  // Depth (in lengths of `direction`) at which a ray goes under the ground; empty where it never does within the
  // raster. Steps of half a cell, then the crossing is interpolated.
  [[nodiscard]] std::optional<double> depth(const geometry::Vec3& origin, const geometry::Vec3& direction) const;

 private:
  geometry::Grid<float> up_;
  double lowest_ = 0.0, highest_ = 0.0;
};

}  // namespace cairn::pipeline
