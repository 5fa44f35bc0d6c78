#include "ground/bandwidth.hpp"

#include <algorithm>

#include "ground/link.hpp"

namespace cairn::ground {

void BandwidthOptions::visit(base::OptionVisitor& v) {
  v.integer("image-width-px", image_width_px, 1, 100000, "bandwidth: width of an image that would be sent");
  v.integer("image-height-px", image_height_px, 1, 100000, "bandwidth: its height");
  v.real("jpeg-bits-per-px", jpeg_bits_per_px, 0.01, 24.0, "bandwidth: of a compressed image");
  v.integer("image-features", features, 0, 10000000, "bandwidth: features of an image, 36 bytes each");
  v.integer("cloud-points", cloud_points, 0, 1000000000, "bandwidth: points of a cloud, 12 bytes each");
  v.real("map-side-m", map_side_m, 0.1, 1e6, "bandwidth: side of an occupancy map");
  v.real("map-resolution-m", map_resolution_m, 1e-3, 1e3, "bandwidth: its resolution");
}

std::vector<BandwidthRow> bandwidth(const std::vector<survey::ReceivedPacket>& packets,
                                    const BandwidthOptions& options) {
  if (packets.size() < 2) return {};
  double bytes = 0.0;
  std::int64_t first = packets.front().packet.capture_time_ns, last = first;
  for (const auto& p : packets) {
    bytes += static_cast<double>(packet_bytes(p.packet));
    first = std::min(first, p.packet.capture_time_ns);
    last = std::max(last, p.packet.capture_time_ns);
  }
  if (last <= first) return {};
  const double count = static_cast<double>(packets.size());
  const double each = bytes / count, rate_hz = (count - 1.0) / (static_cast<double>(last - first) * 1e-9);
  const double pixels = static_cast<double>(options.image_width_px) * static_cast<double>(options.image_height_px);
  const double cells = options.map_side_m / options.map_resolution_m;
  constexpr double kRgb = 3.0, kFeature = 36.0, kPoint = 12.0, kByte = 8.0;
  std::vector<BandwidthRow> rows{{"packets", each, 0, 0},
                                 {"image_raw", kRgb * pixels, 0, 0},
                                 {"image_jpeg", options.jpeg_bits_per_px / kByte * pixels, 0, 0},
                                 {"image_features", kFeature * static_cast<double>(options.features), 0, 0},
                                 {"point_cloud", kPoint * static_cast<double>(options.cloud_points), 0, 0},
                                 {"occupancy_map", cells * cells, 0, 0}};
  for (auto& row : rows) {
    row.bytes_per_s = row.bytes_each * rate_hz;
    row.times_packets = row.bytes_each / each;
  }
  return rows;
}

}  // namespace cairn::ground
