// What a costmap is made of, each source by rows of the map.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "geometry/grid.hpp"
#include "ground/occupancy.hpp"
#include "pipeline/costmap_stage.hpp"
#include "pipeline/map_plane.hpp"
#include "survey/obstacle.hpp"

namespace cairn::pipeline {

class OccupancySource {
 public:
  virtual ~OccupancySource() = default;
  // Ground that it covers, with the resolution it has itself; empty where it has no extent of its own.
  [[nodiscard]] virtual std::optional<geometry::GridGeometry> geometry() const = 0;
  // Rows from `first` on of the map `full` into `strip`, as many as it has. Called with one and the same map.
  virtual void rows(const geometry::GridGeometry& full, std::size_t first, ground::OccupancyGrid& strip) = 0;
};

// A grid in memory.
[[nodiscard]] std::unique_ptr<OccupancySource> make_grid_source(ground::OccupancyGrid grid);

// A prior map of any kind (CostmapInputs::prior). Joins its frame to the plane; polygons need the plane to be known, so
// they come last. Warns where cells are resampled is up to the caller. Throws invalid_input for another kind of file.
[[nodiscard]] std::unique_ptr<OccupancySource> open_prior(const std::filesystem::path& path,
                                                          const CostmapStageOptions& options, MapPlane& plane,
                                                          base::RunContext& ctx);
[[nodiscard]] bool is_polygon_file(const std::filesystem::path& path);
[[nodiscard]] std::unique_ptr<OccupancySource> open_prior_polygons(const std::filesystem::path& path,
                                                                   const CostmapStageOptions& options,
                                                                   const MapPlane& plane, base::RunContext& ctx);

struct ObstacleLayer {
  std::vector<survey::Obstacle> obstacles;
  std::vector<std::vector<geometry::Ring>> outlines;  // obstacles that are polygons
  std::vector<base::Reject> rejects;
  std::size_t read = 0;
};

// obstacles.json.
[[nodiscard]] ObstacleLayer read_obstacle_records(const std::filesystem::path& path, MapPlane& plane);
// A vector file: the layer `obstacles`, or the only one. Points are discs of the column width_m (0 where there is
// none), polygons are filled. The column kind (obstacle, ignored, vehicle) counts where there is one, else the column
// class by the table of classes.
[[nodiscard]] ObstacleLayer read_obstacle_layer(const std::filesystem::path& path, const MapPlane& plane);

}  // namespace cairn::pipeline
