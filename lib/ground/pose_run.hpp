// A recorded drive through the pose filter, with the tracks that it is compared with.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/run_context.hpp"
#include "ground/pose_filter.hpp"

namespace cairn::ground {

// All at the same times: from the first sample on, rate_hz a second, up to the last sample.
struct PoseRun {
  std::vector<survey::VehicleState> filtered;       // from what had arrived by then
  std::vector<survey::VehicleState> inertial;       // the log's own positions, carried on from its last sample
  std::vector<survey::VehicleState> dead_reckoned;  // the log's velocities summed from its first position
  // The projected position that arrived last, as it came: the first of its packet. Empty before the first.
  std::vector<std::optional<geometry::Vec2>> projected;
  std::vector<PoseUpdate> updates;
};

// Samples and packets are given to the filter in order of sample time and arrival, as they would have come. log:
// ascending times, at least one sample. packets: ascending arrival. Positions that count for a time behind the log's
// end are refused with the reason after_log. Cost: of a PoseFilter, and linear in the states.
[[nodiscard]] PoseRun run_pose_filter(std::span<const survey::VehicleState> log,
                                      std::span<const survey::ReceivedPacket> packets, const PoseFilterOptions& options,
                                      double rate_hz, const base::RunContext& ctx);

// Median interval of the samples, s; 0 for fewer than two.
[[nodiscard]] double median_interval_s(std::span<const survey::VehicleState> log);

}  // namespace cairn::ground
