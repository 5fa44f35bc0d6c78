// ROS maps (nav2_map_server): image + YAML, with the georeference in a file of its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/geodetic.hpp"
#include "geometry/grid.hpp"
#include "survey/manifest.hpp"

namespace cairn::io {

// How pixels become occupancy (nav2_map_server, map_io.cpp; occ = 1 - pixel/255, or pixel/255 when negated):
//   trinary: occ > occupied_thresh = 100, occ < free_thresh = 0, else unknown;
//            Opacity, where the image has it, is averaged in as a fourth channel;
//   scale:   the same, but linear 0..100 between the thresholds; "unknown" is a pixel that is not opaque, so a map with
//            unknown cells is a PNG;
//   raw:     the pixel itself where 0..100, else unknown; negate and thresholds do not count.
enum class MapMode { trinary, scale, raw };
[[nodiscard]] std::string_view name_of(MapMode mode);

inline constexpr std::uint8_t kOccupancyUnknown = 255;  // -1 of nav_msgs/OccupancyGrid

struct RosMap {
  // 0 = free .. 100 = occupied, 255 = unknown; rows north to south, coordinates of the map frame in
  // metres (the survey's local east, north).
  geometry::Grid<std::uint8_t> occupancy;
  MapMode mode = MapMode::trinary;
  double occupied_thresh = 0.65;  // 0..1, > free_thresh
  // With the usual 0.25 unknown cells (pixel 205, occ 0.196) would load as free.
  double free_thresh = 0.1;  // 0..1
  // Only where a turned map was read as declared (RosMapReading): counter-clockwise about its lower left corner, rad.
  // The geometry is that of the map before it is turned.
  double yaw = 0.0;
};

// Where the map is on Earth: what the YAML cannot say (its numbers are read with few digits and Nav2
// ignores the yaw).
struct MapGeoreference {
  geometry::Geodetic origin;  // of the map frame's (0, 0)
  survey::HeightType height_type = survey::HeightType::unknown;
  std::string geoid;
  std::string crs_wkt;  // in which x = easting, y = northing equal the map frame's x, y
};

// Writes NAME.pgm (NAME.png in mode scale with unknown cells), NAME.yaml and, where the place on Earth is known,
// NAME.georeference.json into an existing folder. Free = 254, occupied = 0, unknown = 205; origin = lower-left corner,
// yaw 0, negate 0.
// Throws invalid_argument where a value does not fit the mode (trinary: 0, 100, 255; scale and raw: 0..100, 255), where
// the thresholds do not keep unknown cells unknown, for a yaw, for a name that is not [A-Za-z0-9_-], and for more than
// 2^31 cells; resource_exhausted where a file cannot be written.
void write_ros_map(const std::filesystem::path& folder, const std::string& name, const RosMap& map,
                   const std::optional<MapGeoreference>& georeference);

struct RosMapReading {
  bool accept_yaw = false;  // the caller takes RosMap::yaw into account
};

// Reads a YAML and the image it names (map_image.hpp), which must lie inside the YAML's folder. Strict: the
// keys image, resolution, origin, negate, occupied_thresh, free_thresh have to be there once each; yaw
// must be 0 unless it is accepted. Throws not_found or invalid_input with the line or byte.
[[nodiscard]] RosMap read_ros_map(const std::filesystem::path& yaml, const RosMapReading& reading = {});

// The image that a YAML names; the same refusals.
[[nodiscard]] std::filesystem::path ros_map_image(const std::filesystem::path& yaml);

// NAME.georeference.json.
[[nodiscard]] MapGeoreference read_map_georeference(const std::filesystem::path& path);

}  // namespace cairn::io
