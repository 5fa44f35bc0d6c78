// A 10 m x 8 m piece of ground with one boulder, one tree and a corner that was not seen, as files.
#pragma once

#include <filesystem>
#include <limits>

#include "geodesy/local_frame.hpp"
#include "io/obstacles_json.hpp"
#include "io/raster.hpp"

namespace cairn::testing {

inline const geometry::Geodetic kSmallGroundOrigin{46.8426, -91.994, 158.0};

// Writes surface.tif and obstacles.json. Boulder: 1 m wide at (5, 4); tree at (2, 2). No heights in the
// north-eastern 2 m x 2 m.
inline void write_small_ground(const std::filesystem::path& folder) {
  geometry::Grid<float> height({0.0, 8.0, 0.25, 40, 32}, 1.0F);
  for (std::size_t r = 0; r < 8; ++r)
    for (std::size_t c = 32; c < 40; ++c) height.at(r, c) = std::numeric_limits<float>::quiet_NaN();
  const geodesy::LocalFrame frame(kSmallGroundOrigin);
  io::write_cog(folder / "surface.tif", {{"surface", "m", "test", height, std::nullopt}}, frame.raster_crs_wkt());

  survey::Obstacle boulder;
  boulder.target = survey::TargetId(1);
  boulder.object_class = "boulder";
  boulder.position = {5.0, 4.0, 1.0};
  boulder.width_m = 1.0;
  survey::Obstacle tree = boulder;
  tree.target = survey::TargetId(2);
  tree.object_class = "tree";
  tree.kind = survey::ObstacleKind::ignored;
  tree.position = {2.0, 2.0, 1.0};
  io::write_obstacles(folder / "obstacles.json",
                      {{kSmallGroundOrigin, survey::HeightType::ellipsoidal, ""}, {boulder, tree}});
}

}  // namespace cairn::testing
