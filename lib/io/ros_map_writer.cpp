#include "io/ros_map_writer.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/bytes.hpp"
#include "io/json.hpp"
#include "io/map_image.hpp"

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
  if (g.columns == 0 || g.rows == 0 || g.columns > kMaxCells / g.rows || g.cells() == 0)
    refuse("a map of a size that ROS cannot load", std::to_string(g.columns) + " x " + std::to_string(g.rows),
           "1 to 2^31 cells; split it into tiles");
  if (!(g.cell > 0.0) || !std::isfinite(g.cell) || !std::isfinite(g.west) || !std::isfinite(g.north))
    refuse("a map without a usable place", "cell " + base::to_text(g.cell), "finite numbers, cell > 0");
  if (!(map.free_thresh >= 0.0 && map.free_thresh < map.occupied_thresh && map.occupied_thresh <= 1.0))
    refuse("thresholds that do not part free from occupied",
           base::to_text(map.free_thresh) + " and " + base::to_text(map.occupied_thresh), "0 <= free < occupied <= 1");
  if (map.yaw != 0.0) refuse("a turned map", "yaw " + base::to_text(map.yaw), "yaw 0: Nav2 ignores it");
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

std::string yaml(const std::string& name, const char* extension, const RosMap& map) {
  const auto& g = map.occupancy.geometry;
  return "image: " + name + extension + "\nmode: " + std::string(name_of(map.mode)) +
         "\nresolution: " + base::to_text(g.cell) + "\norigin: [" + base::to_text(g.west) + ", " +
         base::to_text(g.south()) + ", 0]\nnegate: 0\noccupied_thresh: " + base::to_text(map.occupied_thresh) +
         "\nfree_thresh: " + base::to_text(map.free_thresh) + "\n";
}

[[noreturn]] void refuse_value(const RosMap& map, std::uint64_t cell, std::uint8_t value) {
  const std::size_t columns = map.occupancy.geometry.columns;
  throw Error(ErrorCode::invalid_argument, "an occupancy that mode " + std::string(name_of(map.mode)) + " cannot hold")
      .file("ROS map")
      .record("row " + std::to_string(cell / columns) + ", column " + std::to_string(cell % columns))
      .found(std::to_string(value))
      .allowed(map.mode == MapMode::trinary ? "0, 100, 255"
               : map.mode == MapMode::scale ? "0 to 100"
                                            : "0 to 100, 255");
}

void write_georeference(const std::filesystem::path& folder, const std::string& name,
                        const MapGeoreference& georeference) {
  const Json place = Json::object({{"schema_version", 1},
                                   {"map", name + ".yaml"},
                                   {"frame", "local east-north-up about the origin, metres"},
                                   {"origin", Json::object({{"latitude_deg", georeference.origin.latitude_deg},
                                                            {"longitude_deg", georeference.origin.longitude_deg},
                                                            {"height_m", georeference.origin.height_m},
                                                            {"height_type", survey::name_of(georeference.height_type)},
                                                            {"geoid", georeference.geoid}})},
                                   {"crs_wkt", georeference.crs_wkt}});
  base::write_file(folder / (name + ".georeference.json"), place.dump() + "\n");
}

// Unknown cells of mode scale are pixels that one can see through.
void write_scale_png(const std::filesystem::path& folder, const std::string& name, const RosMap& map) {
  const auto table = pixel_table(map);
  const auto& g = map.occupancy.geometry;
  std::vector<std::uint8_t> grey(map.occupancy.values.size()), opacity(grey.size(), 255);
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const std::uint8_t value = map.occupancy.values[i];
    const bool unknown = value == kOccupancyUnknown;
    if (!unknown && table[value] < 0) refuse_value(map, i, value);
    grey[i] = unknown ? kUnknownPixel : static_cast<std::uint8_t>(table[value]);
    if (unknown) opacity[i] = 0;
  }
  write_map_png(folder / (name + ".png"), g.columns, g.rows, grey, opacity);
}

}  // namespace

RosMapWriter::RosMapWriter(std::filesystem::path folder, std::string name, const RosMap& map,
                           std::optional<MapGeoreference> georeference)
    : folder_(std::move(folder)), name_(std::move(name)), georeference_(std::move(georeference)) {
  map_.occupancy.geometry = map.occupancy.geometry;
  map_.mode = map.mode;
  map_.occupied_thresh = map.occupied_thresh;
  map_.free_thresh = map.free_thresh;
  map_.yaw = map.yaw;
  check(name_, map_);
  pixels_ = pixel_table(map_);
  image_ = std::make_unique<OutputFile>(folder_ / (name_ + ".pgm"));
  const auto& g = map_.occupancy.geometry;
  image_->write("P5\n" + std::to_string(g.columns) + " " + std::to_string(g.rows) + "\n255\n");
}

RosMapWriter::~RosMapWriter() = default;

void RosMapWriter::rows(std::span<const std::uint8_t> occupancy) {
  std::string bytes(occupancy.size(), '\0');
  for (std::size_t i = 0; i < occupancy.size(); ++i) {
    const int pixel = pixels_[occupancy[i]];
    if (pixel < 0) refuse_value(map_, cells_ + i, occupancy[i]);
    bytes[i] = static_cast<char>(static_cast<unsigned char>(pixel));
  }
  image_->write(bytes);
  cells_ += occupancy.size();
}

void RosMapWriter::finish() {
  if (cells_ != map_.occupancy.geometry.cells())
    throw Error(ErrorCode::internal, "a ROS map with missing rows").file((folder_ / name_).string());
  image_->close();
  if (georeference_) write_georeference(folder_, name_, *georeference_);
  base::write_file(folder_ / (name_ + ".yaml"), yaml(name_, ".pgm", map_));
}

void write_ros_map(const std::filesystem::path& folder, const std::string& name, const RosMap& map,
                   const std::optional<MapGeoreference>& georeference) {
  check(name, map);
  const auto& values = map.occupancy.values;
  if (values.size() != map.occupancy.geometry.cells())
    refuse("a map without a value for each cell", std::to_string(values.size()),
           std::to_string(map.occupancy.geometry.cells()));
  if (map.mode == MapMode::scale && std::find(values.begin(), values.end(), kOccupancyUnknown) != values.end()) {
    write_scale_png(folder, name, map);
    if (georeference) write_georeference(folder, name, *georeference);
    base::write_file(folder / (name + ".yaml"), yaml(name, ".png", map));
    return;
  }
  RosMapWriter writer(folder, name, map, georeference);
  writer.rows(values);
  writer.finish();
}

}  // namespace cairn::io
