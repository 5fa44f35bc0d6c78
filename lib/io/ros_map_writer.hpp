// A ROS map written from the top downwards, some rows at a time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "io/ros_map.hpp"

namespace cairn::io {

class OutputFile;

// The same files as write_ros_map() but for the PNG of mode scale: unknown cells are refused there.
class RosMapWriter {
 public:
  // `map` gives geometry, mode and thresholds; its values are not looked at. Throws as write_ros_map().
  RosMapWriter(std::filesystem::path folder, std::string name, const RosMap& map,
               std::optional<MapGeoreference> georeference);
  ~RosMapWriter();
  RosMapWriter(const RosMapWriter&) = delete;
  RosMapWriter& operator=(const RosMapWriter&) = delete;

  // Whole rows, from the north.
  void rows(std::span<const std::uint8_t> occupancy);
  // Sidecar and YAML. Throws internal where rows are missing.
  void finish();

 private:
  std::filesystem::path folder_;
  std::string name_;
  RosMap map_;
  std::optional<MapGeoreference> georeference_;
  std::array<int, 256> pixels_{};
  std::unique_ptr<OutputFile> image_;
  std::uint64_t cells_ = 0;
};

}  // namespace cairn::io
