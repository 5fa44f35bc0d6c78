#include "io/ros_map.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/json.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kMaxCells = std::size_t{1} << 31U;
constexpr std::uint8_t kFreePixel = 254, kOccupiedPixel = 0, kUnknownPixel = 205;

double occupancy_of(std::uint8_t pixel) {
  return 1.0 - static_cast<double>(pixel) / 255.0;
}

[[noreturn]] void refuse(std::string message, const std::string& found, const std::string& allowed) {
  throw Error(ErrorCode::invalid_argument, std::move(message)).file("ROS map").found(found).allowed(allowed);
}

void check(const std::string& name, const RosMap& map) {
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  if (name.empty() || !std::all_of(name.begin(), name.end(), plain))
    refuse("a map name that is no plain word", "'" + name + "'", "[A-Za-z0-9_-]");
  const auto& g = map.occupancy.geometry;
  if (g.columns == 0 || g.rows == 0 || g.columns > kMaxCells / g.rows || map.occupancy.values.size() != g.cells())
    refuse("a map of a size that ROS cannot load", std::to_string(g.columns) + " x " + std::to_string(g.rows),
           "1 to 2^31 cells; split it into tiles");
  if (!(g.cell > 0.0) || !std::isfinite(g.cell) || !std::isfinite(g.west) || !std::isfinite(g.north))
    refuse("a map without a usable place", "cell " + base::to_text(g.cell), "finite numbers, cell > 0");
  if (!(map.free_thresh >= 0.0 && map.free_thresh < map.occupied_thresh && map.occupied_thresh <= 1.0))
    refuse("thresholds that do not part free from occupied",
           base::to_text(map.free_thresh) + " and " + base::to_text(map.occupied_thresh), "0 <= free < occupied <= 1");
  if (map.mode != MapMode::trinary) return;
  const double unknown = occupancy_of(kUnknownPixel);
  if (!(unknown >= map.free_thresh && unknown <= map.occupied_thresh && occupancy_of(kFreePixel) < map.free_thresh &&
        occupancy_of(kOccupiedPixel) > map.occupied_thresh))
    refuse("thresholds with which free, unknown and occupied cells would be taken for one another",
           "free_thresh " + base::to_text(map.free_thresh) + ", occupied_thresh " + base::to_text(map.occupied_thresh),
           "free_thresh 0.004 to 0.196, occupied_thresh 0.196 to 1");
}

// Pixel of every occupancy value; -1 where the mode has none.
std::array<int, 256> pixel_table(const RosMap& map) {
  std::array<int, 256> table{};
  table.fill(-1);
  for (int value = 0; value <= 100; ++value) {
    auto& pixel = table[static_cast<std::size_t>(value)];
    if (map.mode == MapMode::raw) {
      pixel = value;
    } else if (value == 0) {
      pixel = kFreePixel;
    } else if (value == 100) {
      pixel = kOccupiedPixel;
    } else if (map.mode == MapMode::scale) {
      const double occ = map.free_thresh + value / 100.0 * (map.occupied_thresh - map.free_thresh);
      pixel = static_cast<int>(std::lround(255.0 * (1.0 - occ)));
    }
  }
  if (map.mode == MapMode::trinary) table[kOccupancyUnknown] = kUnknownPixel;
  if (map.mode == MapMode::raw) table[kOccupancyUnknown] = 255;
  return table;
}

std::string pgm(const RosMap& map) {
  const auto& g = map.occupancy.geometry;
  const auto table = pixel_table(map);
  std::string bytes = "P5\n" + std::to_string(g.columns) + " " + std::to_string(g.rows) + "\n255\n";
  bytes.reserve(bytes.size() + g.cells());
  for (std::size_t i = 0; i < map.occupancy.values.size(); ++i) {
    const int pixel = table[map.occupancy.values[i]];
    if (pixel < 0)
      throw Error(ErrorCode::invalid_argument,
                  "an occupancy that mode " + std::string(name_of(map.mode)) + " cannot hold")
          .file("ROS map")
          .record("row " + std::to_string(i / g.columns) + ", column " + std::to_string(i % g.columns))
          .found(std::to_string(map.occupancy.values[i]))
          .allowed(map.mode == MapMode::trinary ? "0, 100, 255"
                   : map.mode == MapMode::scale ? "0 to 100"
                                                : "0 to 100, 255");
    bytes += static_cast<char>(static_cast<unsigned char>(pixel));
  }
  return bytes;
}

std::string yaml(const std::string& name, const RosMap& map) {
  const auto& g = map.occupancy.geometry;
  return "image: " + name + ".pgm\nmode: " + std::string(name_of(map.mode)) + "\nresolution: " + base::to_text(g.cell) +
         "\norigin: [" + base::to_text(g.west) + ", " + base::to_text(g.south()) +
         ", 0]\nnegate: 0\noccupied_thresh: " + base::to_text(map.occupied_thresh) +
         "\nfree_thresh: " + base::to_text(map.free_thresh) + "\n";
}

}  // namespace

std::string_view name_of(MapMode mode) {
  switch (mode) {
    case MapMode::trinary: return "trinary";
    case MapMode::scale: return "scale";
    case MapMode::raw: return "raw";
  }
  return "trinary";
}

void write_ros_map(const std::filesystem::path& folder, const std::string& name, const RosMap& map,
                   const MapGeoreference& georeference) {
  check(name, map);
  const Json place = Json::object({{"schema_version", 1},
                                   {"map", name + ".yaml"},
                                   {"frame", "local east-north-up about the origin, metres"},
                                   {"origin", Json::object({{"latitude_deg", georeference.origin.latitude_deg},
                                                            {"longitude_deg", georeference.origin.longitude_deg},
                                                            {"height_m", georeference.origin.height_m},
                                                            {"height_type", survey::name_of(georeference.height_type)},
                                                            {"geoid", georeference.geoid}})},
                                   {"crs_wkt", georeference.crs_wkt}});
  base::write_file(folder / (name + ".pgm"), pgm(map));
  base::write_file(folder / (name + ".georeference.json"), place.dump() + "\n");
  base::write_file(folder / (name + ".yaml"), yaml(name, map));
}

MapGeoreference read_map_georeference(const std::filesystem::path& path) {
  const Json json = read_json(path);
  try {
    MapGeoreference out;
    const Json& origin = json.at("origin");
    out.origin = {origin.at("latitude_deg").as_real(), origin.at("longitude_deg").as_real(),
                  origin.at("height_m").as_real()};
    const auto type = survey::height_type_from(origin.at("height_type").as_string());
    if (!type)
      throw Error(ErrorCode::invalid_input, "an unknown height type")
          .found("'" + origin.at("height_type").as_string() + "'");
    out.height_type = *type;
    out.geoid = origin.at("geoid").as_string();
    out.crs_wkt = json.at("crs_wkt").as_string();
    return out;
  } catch (Error& error) {
    error.default_file(path.string());
    throw;
  }
}

}  // namespace cairn::io
