// A survey's detections, frame by frame, to packets and to obstacles over time.
#pragma once

#include <cstdint>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "ground/frame_packet.hpp"
#include "ground/obstacle_map.hpp"
#include "survey/survey.hpp"

namespace cairn::pipeline {

struct ProjectedObstacles {
  std::vector<survey::Packet> packets;       // one a frame, in order of time; what the aircraft would have sent
  std::vector<survey::Obstacle> obstacles;   // of the detections not in `located`; ascending id
  std::vector<geometry::Ring> footprints;    // one a frame of the survey, in its order
  std::vector<base::Reject> rejects;         // of the projector and of the map
  std::vector<std::string> unknown_classes;  // each once
  std::size_t detections = 0;                // that were projected
  bool times_known = true;  // false: all frames carry the same time; packets are numbered in nanoseconds, nothing moves
};

// Detections of ignored classes go into the map but not into the packets. located: detections that a located object
// stands for; they are in the packets, and not in the map. first_id: of the map's obstacles.
// Memory: the survey's packets. Cost: linear in detections and frames.
[[nodiscard]] ProjectedObstacles project_survey(const survey::Survey& survey, const ground::GroundHeight& ground,
                                                const ground::ClassTable& classes,
                                                const ground::ProjectionOptions& projection,
                                                const ground::ObstacleMapOptions& map,
                                                const std::set<survey::DetectionId>& located, std::int64_t first_id,
                                                base::RunContext& ctx);

// Drops projected obstacles that stand where a located one of the same kind does: nearer than half the wider of the
// two plus two sigmas (at most 3 m). Returns how many.
std::size_t drop_explained(std::vector<survey::Obstacle>& projected, std::span<const survey::Obstacle> located);

}  // namespace cairn::pipeline
