#include "ground/pose_run.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace cairn::ground {

using geometry::Vec2;
using survey::VehicleState;

double median_interval_s(std::span<const VehicleState> log) {
  if (log.size() < 2) return 0.0;
  std::vector<std::int64_t> intervals;
  intervals.reserve(log.size() - 1);
  for (std::size_t i = 1; i < log.size(); ++i) intervals.push_back(log[i].time_ns - log[i - 1].time_ns);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return static_cast<double>(*middle) * 1e-9;
}

PoseRun run_pose_filter(std::span<const VehicleState> log, std::span<const survey::ReceivedPacket> packets,
                        const PoseFilterOptions& options, double rate_hz, const base::RunContext& ctx) {
  if (log.empty()) throw base::Error(base::ErrorCode::failed_precondition, "the log has no sample");
  PoseFilter filter(options);
  PoseRun run;
  const std::int64_t start_ns = log.front().time_ns, end_ns = log.back().time_ns;
  const double period_ns = 1e9 / rate_hz;
  std::size_t sample = 0, packet = 0;
  Vec2 summed = log.front().position;
  std::optional<Vec2> projected;
  const auto give_packets = [&](std::int64_t until_ns) {
    for (; packet < packets.size() && packets[packet].arrival_time_ns < until_ns; ++packet) {
      filter.packet(packets[packet]);
      const auto& vehicles = packets[packet].packet.vehicles;
      if (!vehicles.empty() && vehicles.front().position.allFinite()) projected = vehicles.front().position.head<2>();
    }
  };
  constexpr std::size_t kBetweenStops = 4096;
  for (std::size_t k = 0;; ++k) {
    const std::int64_t now_ns = start_ns + static_cast<std::int64_t>(std::llround(static_cast<double>(k) * period_ns));
    if (now_ns > end_ns) break;
    if (k % kBetweenStops == 0) ctx.check_stop();
    for (; sample < log.size() && log[sample].time_ns <= now_ns; ++sample) {
      give_packets(log[sample].time_ns);
      filter.inertial(log[sample]);
      if (sample == 0) continue;
      const auto& before = log[sample - 1];
      summed += 0.5 * (before.velocity + log[sample].velocity) *
                (static_cast<double>(log[sample].time_ns - before.time_ns) * 1e-9);
    }
    give_packets(now_ns + 1);
    const auto& last = log[sample - 1];
    const Vec2 on = last.velocity * (static_cast<double>(now_ns - last.time_ns) * 1e-9);
    run.filtered.push_back(filter.at(now_ns));
    VehicleState inertial = last, dead = last;
    inertial.time_ns = dead.time_ns = now_ns;
    inertial.position += on;
    dead.position = summed + on;
    dead.covariance.reset();
    run.inertial.push_back(inertial);
    run.dead_reckoned.push_back(dead);
    run.projected.push_back(projected);
  }
  // What came behind the last state, for the record.
  for (; sample < log.size(); ++sample) {
    give_packets(log[sample].time_ns);
    filter.inertial(log[sample]);
  }
  for (; packet < packets.size(); ++packet) filter.packet(packets[packet]);
  run.updates = filter.updates();
  for (auto& u : run.updates)
    if (!u.accepted && u.reason.empty()) u.reason = "after_log";
  return run;
}

}  // namespace cairn::ground
