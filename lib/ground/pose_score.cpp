#include "ground/pose_score.hpp"

#include <algorithm>
#include <cmath>

#include "ground/pose_filter.hpp"

namespace cairn::ground {

using geometry::Vec2;
using survey::VehicleState;

std::optional<Vec2> position_at(std::span<const VehicleState> states, std::int64_t time_ns) {
  if (states.empty() || time_ns < states.front().time_ns || time_ns > states.back().time_ns) return std::nullopt;
  const auto after = std::lower_bound(states.begin(), states.end(), time_ns,
                                      [](const VehicleState& s, std::int64_t time) { return s.time_ns < time; });
  if (after->time_ns == time_ns) return after->position;
  const auto before = std::prev(after);
  const double s =
      static_cast<double>(time_ns - before->time_ns) / static_cast<double>(after->time_ns - before->time_ns);
  return Vec2((1.0 - s) * before->position + s * after->position);
}

TrackErrors track_errors(std::span<const VehicleState> track, std::span<const VehicleState> truth) {
  TrackErrors out;
  std::vector<double> errors;
  errors.reserve(track.size());
  double squares = 0.0, nees = 0.0;
  std::size_t with_covariance = 0;
  for (const auto& state : track) {
    const auto position = position_at(truth, state.time_ns);
    if (!position) continue;
    errors.push_back((state.position - *position).norm());
    squares += errors.back() * errors.back();
    if (!state.covariance) continue;
    nees += position_nees(state, *position);
    ++with_covariance;
  }
  if (errors.empty()) return out;
  out.count = errors.size();
  out.rms_m = std::sqrt(squares / static_cast<double>(errors.size()));
  std::sort(errors.begin(), errors.end());
  out.median_m = errors[errors.size() / 2];
  out.p95_m = errors[std::min(errors.size() - 1, errors.size() * 95 / 100)];
  out.max_m = errors.back();
  if (with_covariance > 0) out.nees = nees / static_cast<double>(with_covariance);
  return out;
}

DropoutErrors dropout_errors(std::span<const VehicleState> track, std::span<const VehicleState> truth,
                             const std::vector<std::int64_t>& arrivals_ns, double min_s, double min_m) {
  DropoutErrors out;
  double growth = 0.0, drift = 0.0, distance_squares = 0.0;
  for (std::size_t i = 1; i < arrivals_ns.size(); ++i) {
    const double span_s = static_cast<double>(arrivals_ns[i] - arrivals_ns[i - 1]) * 1e-9;
    if (span_s < min_s) continue;
    // The states from the first behind the last update to the last before the next.
    const auto later = [](const VehicleState& s, std::int64_t time) { return s.time_ns < time; };
    const auto begin = std::lower_bound(track.begin(), track.end(), arrivals_ns[i - 1], later);
    const auto end = std::lower_bound(track.begin(), track.end(), arrivals_ns[i], later);
    if (end - begin < 2) continue;
    const auto first = position_at(truth, begin->time_ns), last = position_at(truth, std::prev(end)->time_ns);
    if (!first || !last) continue;
    double way = 0.0;
    Vec2 before = *first;
    for (auto s = begin + 1; s != end; ++s) {
      const Vec2 here = position_at(truth, s->time_ns).value_or(before);
      way += (here - before).norm();
      before = here;
    }
    if (way < min_m) continue;
    const Vec2 error_first = begin->position - *first, error_last = std::prev(end)->position - *last;
    ++out.count;
    out.longest_s = std::max(out.longest_s, span_s);
    out.distance_m += way;
    distance_squares += way * way;
    growth += error_last.norm() - error_first.norm();
    drift += (error_last - error_first).squaredNorm();
  }
  if (out.count == 0) return out;
  out.growth_percent = 100.0 * growth / out.distance_m;
  out.drift_percent = 100.0 * std::sqrt(drift / distance_squares);
  return out;
}

}  // namespace cairn::ground
