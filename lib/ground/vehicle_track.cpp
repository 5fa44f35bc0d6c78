#include "ground/vehicle_track.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "base/error.hpp"

namespace cairn::ground {

VehicleTrack::VehicleTrack(std::span<const survey::VehicleState> states, double max_gap_s)
    : states_(states.begin(), states.end()), max_gap_ns_(static_cast<std::int64_t>(max_gap_s * 1e9)) {
  for (std::size_t i = 1; i < states_.size(); ++i)
    if (states_[i].time_ns <= states_[i - 1].time_ns)
      throw base::Error(base::ErrorCode::invalid_input, "times of a vehicle's log that do not ascend")
          .found(std::to_string(states_[i].time_ns))
          .allowed("more than " + std::to_string(states_[i - 1].time_ns));
}

std::optional<std::size_t> VehicleTrack::before(std::int64_t time_ns) const {
  const auto after = std::upper_bound(states_.begin(), states_.end(), time_ns,
                                      [](std::int64_t t, const survey::VehicleState& s) { return t < s.time_ns; });
  if (after == states_.begin()) return std::nullopt;
  const auto index = static_cast<std::size_t>(after - states_.begin()) - 1;
  if (states_[index].time_ns == time_ns) return index;
  if (after == states_.end() || after->time_ns - states_[index].time_ns > max_gap_ns_) return std::nullopt;
  return index;
}

std::optional<geometry::Pose2> VehicleTrack::at(std::int64_t time_ns) const {
  const auto index = before(time_ns);
  if (!index) return std::nullopt;
  const survey::VehicleState& a = states_[*index];
  if (a.time_ns == time_ns) return geometry::Pose2{a.position, a.yaw};
  const survey::VehicleState& b = states_[*index + 1];
  const double share = static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
  const double turn = std::remainder(b.yaw - a.yaw, 2.0 * std::numbers::pi);
  return geometry::Pose2{a.position + share * (b.position - a.position), a.yaw + share * turn};
}

double VehicleTrack::tilt(std::int64_t time_ns) const {
  const auto index = before(time_ns);
  if (!index) return 0.0;
  const auto of = [](const survey::VehicleState& s) { return std::max(std::abs(s.roll), std::abs(s.pitch)); };
  return std::max(of(states_[*index]), of(states_[std::min(*index + 1, states_.size() - 1)]));
}

}  // namespace cairn::ground
