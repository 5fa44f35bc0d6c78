// How good a vehicle's track is, where the truth is known.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "survey/ground_vehicle.hpp"

namespace cairn::ground {

// Position at a time, linear between the states (ascending times), m; empty outside their span. Cost log n.
[[nodiscard]] std::optional<geometry::Vec2> position_at(std::span<const survey::VehicleState> states,
                                                        std::int64_t time_ns);

struct TrackErrors {
  std::size_t count = 0;  // states of the track within the truth's span
  double rms_m = 0.0, median_m = 0.0, p95_m = 0.0, max_m = 0.0;
  double nees = 0.0;  // mean over those with a covariance, 2 where it is right; 0 where none has one
};

// Plane distances of the track from the truth at the same times.
[[nodiscard]] TrackErrors track_errors(std::span<const survey::VehicleState> track,
                                       std::span<const survey::VehicleState> truth);

// What a time without updates costs.
struct DropoutErrors {
  std::size_t count = 0;
  double longest_s = 0.0, distance_m = 0.0;  // distance: driven in all of them
  double growth_percent = 0.0;               // sum of |error at end| - |error at start|, of that distance
  double drift_percent = 0.0;                // rms of |error at end - error at start| over rms of the distance
};

// arrivals_ns: of updates, ascending. A dropout is at least min_s without one, and at least min_m of way.
[[nodiscard]] DropoutErrors dropout_errors(std::span<const survey::VehicleState> track,
                                           std::span<const survey::VehicleState> truth,
                                           const std::vector<std::int64_t>& arrivals_ns, double min_s,
                                           double min_m = 0.5);

}  // namespace cairn::ground
