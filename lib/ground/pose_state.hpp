// The Kalman filters of the ground vehicle's pose: one step in time, one position taken in.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "geometry/vec.hpp"

namespace cairn::ground {

struct PoseFilterOptions;

// Error state of the inertial velocity beside the position. v_true = v_ins - bias - heading_error * (turned v_ins).
// Elements: position east, north [m]; velocity bias east, north [m/s]; heading error [rad], the log's yaw minus the
// true one. In paper mode the last three are 0 with no variance: by (B.6) the paper's filter is two-dimensional.
struct PoseEstimate {
  using Vector = Eigen::Matrix<double, 5, 1>;
  using Matrix = Eigen::Matrix<double, 5, 5>;
  Vector mean = Vector::Zero();
  Matrix covariance = Matrix::Zero();

  // What false vehicles are judged by.
  bool accepted_any = false;
  std::int64_t accepted_ns = 0;  // when a projected position was last taken (or the filter started)
  geometry::Vec2 accepted_position = geometry::Vec2::Zero();  // the estimate just behind it
  int refused = 0;                                            // packets in a row without a position that was taken
  geometry::Vec2 refused_offset = geometry::Vec2::Zero();     // mean of their positions minus the estimate
  geometry::Vec2 refused_from = geometry::Vec2::Zero();       // the estimate at the first of them

  [[nodiscard]] geometry::Vec2 position() const { return mean.head<2>(); }
  [[nodiscard]] geometry::Mat2 position_covariance() const { return covariance.topLeftCorner<2, 2>(); }
};

// The inertial velocity with the estimated errors taken off, m/s.
[[nodiscard]] geometry::Vec2 corrected_velocity(const PoseEstimate& estimate, const geometry::Vec2& inertial);

// Moves the estimate by dt [s, >= 0] under the inertial velocity `from` at its start and `to` at its end, m/s. Paper
// mode: (B.5) with (B.6), the velocity at the start. Robust: the mean of both less the estimated errors, which decay
// and grow as first-order Gauss-Markov processes. gap: the log says nothing in between, so the velocity itself is
// uncertain.
void propagate(PoseEstimate& estimate, const geometry::Vec2& from, const geometry::Vec2& to, double dt, bool gap,
               const PoseFilterOptions& options);

// Takes in a position (B.8) with its covariance, m and m^2; Joseph's form, so that the covariance stays one.
void update(PoseEstimate& estimate, const geometry::Vec2& position, const geometry::Mat2& covariance);

// Squared Mahalanobis distance of a position from the estimate.
[[nodiscard]] double gate_distance2(const PoseEstimate& estimate, const geometry::Vec2& position,
                                    const geometry::Mat2& covariance);

}  // namespace cairn::ground
