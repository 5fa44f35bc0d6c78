#include "ground/frame_packet.hpp"

#include <algorithm>
#include <cmath>

#include "ground/image_footprint.hpp"

namespace cairn::ground {

FramePacket make_packet(std::span<const survey::Detection> detections, const survey::Frame& frame,
                        const survey::Camera& camera, const GroundHeight& ground, const ClassTable& classes,
                        const ProjectionOptions& options, std::uint32_t sequence, bool with_ignored) {
  FramePacket result;
  result.packet.sequence = sequence;
  result.packet.capture_time_ns = frame.time_ns;
  const GroundHeight none;
  const GroundHeight& terrain = options.mode == "paper" ? none : ground;
  result.packet.footprint =
      image_footprint(camera, frame.T_world_camera, {terrain, options.ground_up_m},
                      std::min(options.max_range_m, options.footprint_gsd_m * camera.fx_px), options.ray_step_m);
  for (const auto& detection : detections) {
    const auto kind = kind_of_class(detection.object_class, classes);
    if (kind == survey::ObstacleKind::ignored && !with_ignored) continue;
    if (!kind && std::find(result.unknown_classes.begin(), result.unknown_classes.end(), detection.object_class) ==
                     result.unknown_classes.end())
      result.unknown_classes.push_back(detection.object_class);
    const auto projection =
        project_box(detection.box, frame, camera, ground, options, model_of_class(detection.object_class, classes),
                    "detection " + std::to_string(detection.id.value));
    if (const auto* reject = std::get_if<base::Reject>(&projection)) {
      result.rejects.push_back(*reject);
      continue;
    }
    const auto& p = std::get<Projected>(projection);
    if (p.vehicle) {
      result.packet.vehicles.push_back({p.position, p.covariance});
      result.vehicles_of.push_back(detection.id);
    } else {
      result.packet.objects.push_back({p.position, p.covariance, p.width_m, p.height_m, detection.object_class,
                                       std::isfinite(detection.score) ? detection.score : 0.0});
      result.objects_of.push_back(detection.id);
    }
  }
  return result;
}

}  // namespace cairn::ground
