#include "pipeline/costmap_stage.hpp"

#include <cmath>

#include "base/error.hpp"
#include "io/obstacles_json.hpp"
#include "io/raster.hpp"
#include "io/ros_map.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Grid;
using ground::Occupancy;

constexpr std::uint8_t kOccupied100 = 100;  // nav_msgs/OccupancyGrid

const Grid<float>& height_band(const io::Raster& raster, const std::filesystem::path& path) {
  for (const auto& band : raster.bands)
    if (const auto* values = std::get_if<Grid<float>>(&band.values)) return *values;
  throw Error(ErrorCode::invalid_input, "the raster has no band of heights").file(path.string());
}

// Occupancy at the costmap's resolution over the surface's extent: free where a height is known.
ground::OccupancyGrid known_ground(const Grid<float>& heights, double resolution) {
  const geometry::GridGeometry& g = heights.geometry;
  const auto cells = [&](double extent) {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(extent / resolution - 1e-6)));
  };
  const geometry::GridGeometry fine{g.west, g.north, resolution, cells(g.east() - g.west), cells(g.north - g.south())};
  ground::OccupancyGrid occupancy(fine, Occupancy::unknown);
  for (std::size_t r = 0; r < fine.rows; ++r)
    for (std::size_t c = 0; c < fine.columns; ++c) {
      const auto cell = g.cell_at(fine.centre(r, c));
      if (cell && std::isfinite(heights.at(cell->first, cell->second))) occupancy.at(r, c) = Occupancy::free;
    }
  return occupancy;
}

}  // namespace

Outcome costmap_stage(const CostmapInputs& in, const std::filesystem::path& out, const ground::CostmapOptions& options,
                      base::RunContext& ctx) {
  const io::ObstaclesFile obstacles = io::read_obstacles(in.obstacles);
  const io::Raster surface = io::read_raster(in.surface);
  ground::OccupancyGrid occupancy = known_ground(height_band(surface, in.surface), options.resolution_m);
  const auto outside = ground::mark_obstacles(obstacles.obstacles, occupancy).outside;
  ctx.check_stop();
  const Grid<std::uint8_t> cost = ground::costmap(occupancy, options);

  Outcome outcome;
  for (const std::size_t i : outside)
    outcome.rejects.push_back({"obstacle " + std::to_string(obstacles.obstacles[i].target.value), "outside_map",
                               "the obstacle does not touch the mapped area"});

  std::size_t free = 0, occupied = 0, unknown = 0;
  io::RosMap map{Grid<std::uint8_t>(occupancy.geometry, 0), io::MapMode::trinary};
  for (std::size_t i = 0; i < occupancy.values.size(); ++i) {
    std::uint8_t& value = map.occupancy.values[i];
    switch (occupancy.values[i]) {
      case Occupancy::free:
        value = 0;
        ++free;
        break;
      case Occupancy::occupied:
        value = kOccupied100;
        ++occupied;
        break;
      case Occupancy::unknown:
        value = io::kOccupancyUnknown;
        ++unknown;
        break;
    }
  }
  io::write_cog(
      out / "costmap.tif",
      {{"cost", "", "cost of driving, paper B equation (9): 254 obstacle, 253 contact, 252 exp(-alpha (D - R))", cost,
        ground::kUnknown},
       {"occupancy", "", "0 free, 100 occupied", map.occupancy, ground::kUnknown}},
      surface.crs);
  io::write_ros_map(out, "map", map,
                    {obstacles.frame.position, obstacles.frame.height_type, obstacles.frame.geoid, surface.crs});
  const double area = options.resolution_m * options.resolution_m;
  outcome.summary = io::Json::object({{"columns", cost.geometry.columns},
                                      {"rows", cost.geometry.rows},
                                      {"resolution_m", options.resolution_m},
                                      {"radius_m", options.radius_m},
                                      {"free_m2", static_cast<double>(free) * area},
                                      {"occupied_m2", static_cast<double>(occupied) * area},
                                      {"unknown_m2", static_cast<double>(unknown) * area},
                                      {"obstacles", obstacles.obstacles.size()},
                                      {"obstacles_outside", outside.size()}});
  return outcome;
}

}  // namespace cairn::pipeline
