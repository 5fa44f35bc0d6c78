#include "ground/terrain_layers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/angle.hpp"
#include "base/random.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;
constexpr double kFloatM = 1e-4;  // heights are floats of a few metres

TEST(TerrainLayers, PlaneHasItsSlopeAndNoRoughness) {
  Grid<float> heights({0.0, 10.0, 0.25, 40, 40}, 0.0F);
  const double rise = std::tan(base::deg_to_rad(10.0));
  for (std::size_t r = 0; r < 40; ++r)
    for (std::size_t c = 0; c < 40; ++c) {
      const auto p = heights.geometry.centre(r, c);
      heights.at(r, c) = static_cast<float>(rise * (0.6 * p.x() + 0.8 * p.y()));
    }
  const TerrainLayers layers = terrain_layers(heights, {});
  for (const std::size_t r : {0U, 7U, 39U})
    for (const std::size_t c : {0U, 20U, 39U}) {
      EXPECT_NEAR(layers.slope_deg.at(r, c), 10.0, 0.01);
      EXPECT_NEAR(layers.roughness_m.at(r, c), 0.0, kFloatM);
      EXPECT_NEAR(layers.traversability.at(r, c),
                  1.0 - std::max(10.0 / 20.0, static_cast<double>(layers.step_m.at(r, c)) / 0.15), 1e-3);
    }
  // To a diagonal neighbour: 0.25 m to the east and north each.
  EXPECT_NEAR(layers.step_m.at(20, 20), rise * 0.25 * 1.4, kFloatM);
}

TEST(TerrainLayers, StepsAndRoughGroundCannotBeDriven) {
  base::Random random(1, "terrain", 0);
  Grid<float> heights({0.0, 10.0, 0.25, 40, 40}, 0.0F);
  for (std::size_t r = 0; r < 40; ++r)
    for (std::size_t c = 0; c < 40; ++c)
      heights.at(r, c) = c >= 30 ? 0.3F : (c < 10 ? static_cast<float>(random.uniform(-0.06, 0.06)) : 0.0F);
  TerrainLayerOptions options;
  options.max_slope_deg = 60.0;
  options.max_roughness_m = 0.03;
  options.max_step_m = 0.25;
  const TerrainLayers layers = terrain_layers(heights, options);
  const OccupancyGrid grid = drivable(layers);
  EXPECT_EQ(grid.at(20, 29), Occupancy::occupied) << "beside the step";
  EXPECT_EQ(grid.at(20, 30), Occupancy::occupied) << "on its edge";
  EXPECT_EQ(grid.at(20, 35), Occupancy::free);
  EXPECT_EQ(grid.at(20, 20), Occupancy::free);
  EXPECT_FLOAT_EQ(layers.traversability.at(20, 20), 1.0F);
  // Uniform in +-0.06 m: rms 0.035 m, less what a plane of 9 heights takes up.
  double mean = 0.0;
  for (std::size_t r = 1; r < 39; ++r) mean += static_cast<double>(layers.roughness_m.at(r, 5)) / 38.0;
  EXPECT_NEAR(mean, 0.12 / std::sqrt(12.0) * std::sqrt(6.0 / 9.0), 0.006);
}

TEST(TerrainLayers, UnknownStaysUnknown) {
  Grid<float> heights({0.0, 10.0, 0.5, 12, 12}, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t c = 0; c < 12; ++c) heights.at(2, c) = 1.0F;  // one line: no plane
  for (std::size_t r = 6; r < 12; ++r)
    for (std::size_t c = 0; c < 6; ++c) heights.at(r, c) = 1.0F;
  const OccupancyGrid grid = drivable(terrain_layers(heights, {}));
  EXPECT_EQ(grid.at(2, 5), Occupancy::unknown);
  EXPECT_EQ(grid.at(0, 0), Occupancy::unknown);
  EXPECT_EQ(grid.at(8, 3), Occupancy::free);
}

}  // namespace
}  // namespace cairn::ground
