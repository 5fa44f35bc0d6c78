// The numbers that the solver works on: indices instead of ids.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "adjustment/bundle.hpp"
#include "camera/projection_jacobian.hpp"

namespace cairn::adjustment {

struct BundleObservation {
  std::int32_t frame = 0, point = 0;  // into the vectors below
  geometry::Vec2 pixel = geometry::Vec2::Zero();
  double weight = 1.0;   // 1 / sigma_px
  bool control = false;  // of a control point: no tie
};

// A frame's prior: weights are 1 / sigma along [rotation xyz rad, position xyz m], 0 = nothing known.
struct BundlePrior {
  geometry::RigidTransform pose;
  double weight_rot = 0.0, weight_xy = 0.0, weight_z = 0.0;

  [[nodiscard]] bool any() const { return weight_rot > 0.0 || weight_xy > 0.0 || weight_z > 0.0; }
};

struct BundlePointPrior {
  std::int32_t point = 0;
  geometry::Vec3 position = geometry::Vec3::Zero();
  geometry::Vec3 weight = geometry::Vec3::Zero();
};

enum class BundleLoss { none, huber, cauchy };

struct BundleSystem {
  std::vector<survey::Camera> cameras;
  std::vector<geometry::RigidTransform> poses;  // T_world_camera
  std::vector<std::int32_t> camera_of;          // per pose
  std::vector<geometry::Vec3> points;
  std::vector<BundleObservation> observations;  // grouped by point, ascending
  std::vector<BundlePrior> priors;              // per pose
  std::vector<BundlePointPrior> point_priors;
  camera::IntrinsicsSet intrinsics = camera::IntrinsicsSet::none;
  BundleLoss loss = BundleLoss::huber;
  double loss_scale = 3.0, prior_loss_scale = 3.0;
};

struct SolveLimits {
  std::int64_t max_iterations = 50;
  double function_tolerance = 1e-7;
};

// Adjusts poses, points and cameras of the system in place; the round's sigma_px and removed are left alone.
// Every pose must have observations or a prior. Throws cancelled where a stop was requested.
[[nodiscard]] BundleRound solve_bundle(BundleSystem& system, const SolveLimits& limits, base::RunContext& ctx);

// Pose increments are T = (R exp(w), c + v), x = (w, v): w in camera axes [rad], v in world axes [m].
[[nodiscard]] geometry::Mat3 exp_rotation(const geometry::Vec3& w);
[[nodiscard]] geometry::Vec3 log_rotation(const geometry::Mat3& rotation);
// exp(w + d) = exp(w) exp(Jr(w) d) to first order.
[[nodiscard]] geometry::Mat3 right_jacobian(const geometry::Vec3& w);
[[nodiscard]] geometry::Mat3 inverse_right_jacobian(const geometry::Vec3& w);

}  // namespace cairn::adjustment
