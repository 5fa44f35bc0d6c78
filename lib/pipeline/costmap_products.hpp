// The files of a costmap, written from the north.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/grid.hpp"
#include "io/raster.hpp"
#include "io/raster_rows.hpp"
#include "io/ros_map_writer.hpp"

namespace cairn::pipeline {

struct CostmapBand {
  std::string name, description;
};

class CostmapProducts {
 public:
  // bands: of costmap.tif; `cost` is the first and `occupancy` (0, 100, 255) the second. mode: of map.yaml.
  CostmapProducts(std::filesystem::path out, const geometry::GridGeometry& map, std::vector<CostmapBand> bands,
                  std::string crs, io::MapMode mode, std::optional<io::MapGeoreference> place);

  // Whether the raster is written as it comes (above 2^26 cells), and not as a COG at the end.
  [[nodiscard]] bool streams() const { return writer_ != nullptr; }
  // Whether there are ROS maps (up to 2^31 cells).
  [[nodiscard]] bool has_maps() const { return has_maps_; }
  // Bytes that are kept until finish().
  [[nodiscard]] std::uint64_t kept_bytes() const;

  // The next rows: bands[b] holds rows * columns values; keepout holds 0, 100, 255.
  void rows(std::size_t rows, const std::vector<std::vector<std::uint8_t>>& bands,
            const std::vector<std::uint8_t>& keepout);
  void finish();

 private:
  std::filesystem::path out_;
  geometry::GridGeometry map_;
  std::vector<CostmapBand> bands_;
  std::string crs_;
  io::MapMode mode_;
  std::optional<io::MapGeoreference> place_;
  bool has_maps_ = true;
  std::vector<geometry::Grid<std::uint8_t>> kept_;  // bands of a COG
  std::size_t rows_done_ = 0;
  std::unique_ptr<io::RasterWriter> writer_;
  std::unique_ptr<io::RosMapWriter> map_writer_, keepout_writer_;
  std::optional<io::RosMap> scale_map_;  // mode scale with unknown cells needs the whole map
  std::array<std::uint8_t, 256> graded_{};
};

// Cost 0..255 as Nav2 publishes it: 254 -> 100, 253 -> 99, 1..252 -> 1..98, 255 -> unknown
// (nav2_costmap_2d, costmap_2d_publisher.cpp).
[[nodiscard]] std::array<std::uint8_t, 256> graded_occupancy();

}  // namespace cairn::pipeline
