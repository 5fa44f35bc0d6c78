// What packets need of the link, beside what other designs would send (paper B: several kB against MB).
#pragma once

#include <string>
#include <vector>

#include "base/options.hpp"
#include "survey/packet.hpp"

namespace cairn::ground {

// Sizes of the alternatives, each sent at the rate of the packets.
struct BandwidthOptions {
  std::int64_t image_width_px = 1280, image_height_px = 720;  // 720p: paper B's images
  double jpeg_bits_per_px = 1.5;                              // quality about 80
  std::int64_t features = 1000;                       // of an image, 36 bytes each: place and 256-bit descriptor
  std::int64_t cloud_points = 100000;                 // of a depth image or a scanner's turn, 12 bytes each
  double map_side_m = 40.0, map_resolution_m = 0.05;  // occupancy grid, a byte a cell

  void visit(base::OptionVisitor& visitor);
};

struct BandwidthRow {
  std::string what;  // packets, image_raw, image_jpeg, image_features, point_cloud, occupancy_map
  double bytes_each = 0.0, bytes_per_s = 0.0;
  double times_packets = 0.0;  // bytes_each over that of packets
};

// Rates from the capture times; packets first. Empty for fewer than two packets.
[[nodiscard]] std::vector<BandwidthRow> bandwidth(const std::vector<survey::ReceivedPacket>& packets,
                                                  const BandwidthOptions& options);

}  // namespace cairn::ground
