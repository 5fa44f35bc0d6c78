#include "pipeline/projected_obstacles.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "base/error.hpp"

namespace cairn::pipeline {
namespace {

// Indices of the frames in order of time, then id.
std::vector<std::size_t> by_time(const std::vector<survey::Frame>& frames) {
  std::vector<std::size_t> order(frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return frames[a].time_ns < frames[b].time_ns; });
  return order;
}

bool all_at_once(const std::vector<survey::Frame>& frames) {
  return std::all_of(frames.begin(), frames.end(),
                     [&](const survey::Frame& f) { return f.time_ns == frames.front().time_ns; });
}

double worst_sigma(const geometry::Mat2& c) {
  return std::sqrt(std::max(0.0, 0.5 * c.trace() + std::hypot(0.5 * (c(0, 0) - c(1, 1)), c(0, 1))));
}

}  // namespace

ProjectedObstacles project_survey(const survey::Survey& survey, const ground::GroundHeight& ground,
                                  const ground::ClassTable& classes, const ground::ProjectionOptions& projection,
                                  const ground::ObstacleMapOptions& map_options,
                                  const std::set<survey::DetectionId>& located, std::int64_t first_id,
                                  base::RunContext& ctx) {
  ProjectedObstacles result;
  result.footprints.resize(survey.frames.size());
  result.times_known = survey.frames.size() < 2 || !all_at_once(survey.frames);
  auto options = map_options;
  options.classes = classes;
  if (!result.times_known) options.motion = false;
  ground::ObstacleMap map(options, first_id);
  std::map<survey::FrameId, std::vector<survey::Detection>> boxes;
  for (const auto& detection : survey.detections) boxes[detection.frame].push_back(detection);

  std::set<std::string> unknown;
  std::uint32_t sequence = 0;
  std::int64_t last_ns = 0;
  for (const std::size_t index : by_time(survey.frames)) {
    ctx.check_stop();
    const auto& frame = survey.frames[index];
    const auto* camera = survey.camera(frame.camera);
    if (camera == nullptr) continue;
    const auto found = boxes.find(frame.id);
    const std::span<const survey::Detection> here =
        found == boxes.end() ? std::span<const survey::Detection>() : std::span<const survey::Detection>(found->second);
    auto made = ground::make_packet(here, frame, *camera, ground, classes, projection, sequence++, true);
    result.detections += here.size();
    if (!result.times_known) made.packet.capture_time_ns = static_cast<std::int64_t>(made.packet.sequence);
    last_ns = made.packet.capture_time_ns;
    result.footprints[index] = made.packet.footprint;
    result.rejects.insert(result.rejects.end(), made.rejects.begin(), made.rejects.end());
    unknown.insert(made.unknown_classes.begin(), made.unknown_classes.end());

    survey::Packet rest = made.packet, sent = made.packet;
    rest.objects.clear();
    rest.vehicles.clear();
    sent.objects.clear();
    for (std::size_t i = 0; i < made.packet.objects.size(); ++i) {
      const auto& object = made.packet.objects[i];
      if (ground::kind_of_class(object.object_class, classes) != survey::ObstacleKind::ignored)
        sent.objects.push_back(object);
      if (!located.contains(made.objects_of[i])) rest.objects.push_back(object);
    }
    for (std::size_t i = 0; i < made.packet.vehicles.size(); ++i)
      if (!located.contains(made.vehicles_of[i])) rest.vehicles.push_back(made.packet.vehicles[i]);
    const auto report = map.add(rest);
    result.rejects.insert(result.rejects.end(), report.rejects.begin(), report.rejects.end());
    result.packets.push_back(std::move(sent));
  }
  result.unknown_classes.assign(unknown.begin(), unknown.end());
  result.obstacles = map.obstacles(last_ns);
  if (!result.times_known)
    for (auto& o : result.obstacles) o.first_seen_ns = o.last_seen_ns = 0;
  return result;
}

std::size_t drop_explained(std::vector<survey::Obstacle>& projected, std::span<const survey::Obstacle> located) {
  constexpr double kFarthest = 3.0;  // m
  const auto explained = [&](const survey::Obstacle& p) {
    return std::any_of(located.begin(), located.end(), [&](const survey::Obstacle& l) {
      if (l.kind != p.kind) return false;
      const double reach =
          0.5 * std::max(l.width_m, p.width_m) + 2.0 * std::hypot(worst_sigma(l.covariance), worst_sigma(p.covariance));
      return (l.position - p.position).head<2>().norm() <= std::min(reach, std::max(kFarthest, 0.5 * l.width_m));
    });
  };
  const auto first = std::remove_if(projected.begin(), projected.end(), explained);
  const auto count = static_cast<std::size_t>(projected.end() - first);
  projected.erase(first, projected.end());
  return count;
}

}  // namespace cairn::pipeline
