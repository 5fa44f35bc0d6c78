// A vehicle's pose between the lines of its log.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/pose2.hpp"
#include "survey/ground_vehicle.hpp"

namespace cairn::ground {

class VehicleTrack {
 public:
  // states: times ascend strictly, else invalid_input. max_gap_s: between two lines that may be bridged, > 0.
  VehicleTrack(std::span<const survey::VehicleState> states, double max_gap_s);

  // Position linear in time, yaw the shorter way round. Empty before the first line, after the last one, and inside a
  // gap.
  [[nodiscard]] std::optional<geometry::Pose2> at(std::int64_t time_ns) const;
  // Largest of |roll| and |pitch| of the lines around a time, rad; 0 where there is no pose.
  [[nodiscard]] double tilt(std::int64_t time_ns) const;

  [[nodiscard]] std::int64_t begin_ns() const { return states_.empty() ? 0 : states_.front().time_ns; }
  [[nodiscard]] std::int64_t end_ns() const { return states_.empty() ? 0 : states_.back().time_ns; }

 private:
  // Index of the line at or before the time, where the one after it is near enough.
  [[nodiscard]] std::optional<std::size_t> before(std::int64_t time_ns) const;

  std::vector<survey::VehicleState> states_;
  std::int64_t max_gap_ns_ = 0;
};

}  // namespace cairn::ground
