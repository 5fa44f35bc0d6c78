// One frame's detections as the packet that the aircraft sends.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "ground/class_table.hpp"
#include "ground/projector.hpp"
#include "survey/detection.hpp"
#include "survey/packet.hpp"

namespace cairn::ground {

struct FramePacket {
  survey::Packet packet;                         // capture time = the frame's
  std::vector<survey::DetectionId> objects_of;   // detection of each object
  std::vector<survey::DetectionId> vehicles_of;  // detection of each vehicle
  std::vector<base::Reject> rejects;             // of project_box, by detection
  std::vector<std::string> unknown_classes;      // taken as obstacles, each once; the caller warns
};

// detections: those of the frame. Objects and vehicles come in their order. Ignored classes (trees) are left out unless
// with_ignored. The footprint is the ground that the image shows at options.footprint_gsd_m or finer.
[[nodiscard]] FramePacket make_packet(std::span<const survey::Detection> detections, const survey::Frame& frame,
                                      const survey::Camera& camera, const GroundHeight& ground,
                                      const ClassTable& classes, const ProjectionOptions& options,
                                      std::uint32_t sequence, bool with_ignored = false);

}  // namespace cairn::ground
