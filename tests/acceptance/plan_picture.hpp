// A survey's photographs seen from above, to draw on.
#pragma once

#include <filesystem>
#include <string>

#include "geometry/grid.hpp"

namespace cairn::acceptance {

struct PlanPicture {
  geometry::GridGeometry geometry;  // local east, north, m
  std::string jpeg;                 // one pixel a cell, no photograph = white
};

// Each cell takes the colour of the photograph whose camera stands nearest above it, by the height of `surface`
// (a raster in the survey's local frame; where it knows none, that of the last cell before it).
[[nodiscard]] PlanPicture plan_picture(const std::filesystem::path& survey_folder, const std::filesystem::path& surface,
                                       double cell_m);

}  // namespace cairn::acceptance
