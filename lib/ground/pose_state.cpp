#include "ground/pose_state.hpp"

#include <Eigen/LU>
#include <cmath>

#include "base/angle.hpp"
#include "ground/pose_filter.hpp"

namespace cairn::ground {
namespace {

using geometry::Mat2;
using geometry::Vec2;

// Turned by a right angle, counter-clockwise: the derivative of a turned vector by the angle.
Vec2 turned(const Vec2& v) {
  return {-v.y(), v.x()};
}

// (B.5) to (B.7) with their covariance: V is replaced at each step, so its variance is Q_V and it is uncorrelated to P.
void propagate_paper(PoseEstimate& e, const Vec2& from, double dt, const PoseFilterOptions& options) {
  e.mean.head<2>() += 0.5 * (from + from) * dt;
  const double q_position = options.paper_sigma_position_m * options.paper_sigma_position_m;
  const double q_velocity = options.paper_sigma_velocity_m_s * options.paper_sigma_velocity_m_s;
  e.covariance.diagonal().head<2>().array() += q_position + 0.25 * dt * dt * q_velocity;
}

}  // namespace

Vec2 corrected_velocity(const PoseEstimate& e, const Vec2& inertial) {
  return inertial - e.mean.segment<2>(2) - e.mean[4] * turned(inertial);
}

void propagate(PoseEstimate& e, const Vec2& from, const Vec2& to, double dt, bool gap,
               const PoseFilterOptions& options) {
  if (!(dt > 0.0)) return;
  if (options.mode == "paper") {
    propagate_paper(e, from, dt, options);
    return;
  }
  const Vec2 inertial = 0.5 * (from + to);
  e.mean.head<2>() += corrected_velocity(e, inertial) * dt;
  const double keep_bias = std::exp(-dt / options.bias_time_s), keep_heading = std::exp(-dt / options.heading_time_s);
  PoseEstimate::Matrix f = PoseEstimate::Matrix::Identity();
  f(0, 2) = f(1, 3) = -dt;
  f.block<2, 1>(0, 4) = -dt * turned(inertial);
  f(2, 2) = f(3, 3) = keep_bias;
  f(4, 4) = keep_heading;
  e.mean.segment<2>(2) *= keep_bias;
  e.mean[4] *= keep_heading;
  e.covariance = (f * e.covariance * f.transpose()).eval();
  const double heading = base::deg_to_rad(options.heading_sigma_deg);
  // Noise of the log's samples, averaged over its own steps; in a gap one unknown velocity for its whole length.
  const double white = options.velocity_noise_m_s * options.velocity_noise_m_s * options.sample_interval_s * dt;
  const double unknown = gap ? options.gap_sigma_m_s * options.gap_sigma_m_s * dt * dt : 0.0;
  e.covariance.diagonal().head<2>().array() += white + unknown;
  e.covariance.diagonal().segment<2>(2).array() +=
      options.bias_sigma_m_s * options.bias_sigma_m_s * (1.0 - keep_bias * keep_bias);
  e.covariance(4, 4) += heading * heading * (1.0 - keep_heading * keep_heading);
}

void update(PoseEstimate& e, const Vec2& position, const Mat2& covariance) {
  const Eigen::Matrix<double, 5, 2> cross = e.covariance.leftCols<2>();
  const Mat2 innovation = e.position_covariance() + covariance;
  const Eigen::Matrix<double, 5, 2> gain = cross * innovation.inverse();
  e.mean += gain * (position - e.position());
  PoseEstimate::Matrix keep = PoseEstimate::Matrix::Identity();
  keep.leftCols<2>() -= gain;
  e.covariance = (keep * e.covariance * keep.transpose() + gain * covariance * gain.transpose()).eval();
  e.covariance = (0.5 * (e.covariance + e.covariance.transpose())).eval();
}

double gate_distance2(const PoseEstimate& e, const Vec2& position, const Mat2& covariance) {
  const Vec2 offset = position - e.position();
  return offset.dot((e.position_covariance() + covariance).inverse() * offset);
}

}  // namespace cairn::ground
