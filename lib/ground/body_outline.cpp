#include "ground/body_outline.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "camera/projection.hpp"

namespace cairn::ground {
namespace {

using geometry::PixelBox;
using geometry::RigidTransform;
using geometry::Vec2;
using geometry::Vec3;
using Vec4 = Eigen::Vector4d;
using Mat4 = Eigen::Matrix4d;

// Level circle of the body: fractions of its height and of half its width.
struct Level {
  double height, radius;
};

constexpr std::array<Level, 2> kCylinder{{{0.0, 1.0}, {1.0, 1.0}}};
constexpr std::array<Level, 2> kCone{{{0.0, 1.0}, {1.0, 0.1}}};
// Upright ellipsoid on its lower pole: radius sqrt(1 - (2 h - 1)^2).
constexpr std::array<Level, 9> kBall{{{0.0, 0.0},
                                      {0.05, 0.43588989435406736},
                                      {0.15, 0.71414284285428498},
                                      {0.3, 0.91651513899116799},
                                      {0.5, 1.0},
                                      {0.7, 0.91651513899116799},
                                      {0.85, 0.71414284285428498},
                                      {0.95, 0.43588989435406736},
                                      {1.0, 0.0}}};

std::span<const Level> levels_of(Shape shape) {
  switch (shape) {
    case Shape::cylinder: return kCylinder;
    case Shape::cone: return kCone;
    case Shape::ball: return kBall;
  }
  return kCylinder;
}

// Largest value of a smooth periodic sequence, by the parabola through its largest sample and that one's neighbours.
double peak(std::span<const double> values, double sign) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < values.size(); ++i)
    if (sign * values[i] > sign * values[best]) best = i;
  const std::size_t n = values.size();
  const double left = values[(best + n - 1) % n], middle = values[best], right = values[(best + 1) % n];
  const double curvature = left - 2.0 * middle + right;
  if (!(std::abs(curvature) > 0.0)) return middle;
  const double shift = 0.5 * (left - right) / curvature;
  return std::abs(shift) <= 1.0 ? middle - 0.25 * (left - right) * shift : middle;
}

struct GroundPlane {
  Vec3 at = Vec3::Zero();
  Vec2 slope = Vec2::Zero();
  [[nodiscard]] double up(const Vec2& p) const { return at.z() + slope.dot(p - at.head<2>()); }
};

GroundPlane plane_at(const Ground& ground, const Vec2& p, double base) {
  if (!ground.terrain) return {Vec3(p.x(), p.y(), ground.plane_up), Vec2::Zero()};
  const double h = 0.5 * base;
  const double west = ground.up(p.x() - h, p.y()), east = ground.up(p.x() + h, p.y()),
               south = ground.up(p.x(), p.y() - h), north = ground.up(p.x(), p.y() + h);
  return {Vec3(p.x(), p.y(), ground.up(p.x(), p.y())), Vec2((east - west) / base, (north - south) / base)};
}

// One fit over a plane: x = (east, north, log width, log height).
class Problem {
 public:
  Problem(const PixelBox& box, const survey::Camera& camera, const RigidTransform& pose, const GroundPlane& plane,
          const ObjectModel& model, const FitNoise& noise)
      : edges_(box.xmin, box.ymin, box.xmax, box.ymax),
        camera_(camera),
        pose_(pose),
        plane_(plane),
        model_(model),
        noise_(noise) {
    for (int i = 0; i < 4; ++i) weight_[i] = 1.0 / noise.edge_px.at(static_cast<std::size_t>(i));
  }

  [[nodiscard]] UprightBody body(const Vec4& x, double raise = 0.0) const {
    const Vec2 p = x.head<2>();
    return {model_.shape, Vec3(p.x(), p.y(), plane_.up(p) + model_.base_above_ground_m + raise), std::exp(x[2]),
            std::exp(x[3])};
  }

  // Residuals over their sigmas.
  [[nodiscard]] std::optional<Vec4> edges(const Vec4& x, const RigidTransform& pose, double raise = 0.0) const {
    const auto b = outline_box(body(x, raise), camera_, pose);
    if (!b) return std::nullopt;
    return Vec4((Vec4(b->xmin, b->ymin, b->xmax, b->ymax) - edges_).cwiseProduct(weight_));
  }
  [[nodiscard]] double prior(const Vec4& x) const {
    return (x[3] - std::log(model_.height) - (model_.height_by_width ? x[2] : 0.0)) / model_.sigma_log_height;
  }
  [[nodiscard]] Vec4 prior_slope() const {
    return Vec4(0.0, 0.0, model_.height_by_width ? -1.0 : 0.0, 1.0) / model_.sigma_log_height;
  }
  [[nodiscard]] std::optional<double> cost(const Vec4& x) const {
    const auto r = edges(x, pose_);
    if (!r) return std::nullopt;
    const double p = prior(x);
    return r->squaredNorm() + p * p;
  }

  [[nodiscard]] std::optional<Mat4> jacobian(const Vec4& x) const {
    const double level = 1e-4 * std::exp(x[2]);
    const Vec4 step(level, level, 1e-4, 1e-4);
    Mat4 j;
    for (int k = 0; k < 4; ++k) {
      const auto ahead = edges(x + step[k] * Vec4::Unit(k), pose_), behind = edges(x - step[k] * Vec4::Unit(k), pose_);
      if (!ahead || !behind) return std::nullopt;
      j.col(k) = (*ahead - *behind) / (2.0 * step[k]);
    }
    return j;
  }

  [[nodiscard]] std::optional<Vec4> solve(Vec4 x) const {
    auto current = cost(x);
    if (!current) return std::nullopt;
    double damping = 1e-3;
    constexpr int kMostSteps = 60;
    constexpr double kStill = 1e-10;  // m and log units
    for (int i = 0; i < kMostSteps; ++i) {
      const auto j = jacobian(x);
      const auto r = edges(x, pose_);
      if (!j || !r) return std::nullopt;
      const Vec4 s = prior_slope();
      const Mat4 a = j->transpose() * *j + s * s.transpose();
      const Vec4 g = j->transpose() * *r + s * prior(x);
      bool better = false;
      Vec4 step = Vec4::Zero();
      for (int tries = 0; tries < 12 && !better; ++tries) {
        Mat4 damped = a;
        damped.diagonal() += damping * a.diagonal() + Vec4::Constant(1e-12);
        step = -damped.ldlt().solve(g);
        // A leap in size is a sign of a poor start, not of the object.
        const double leap = step.tail<2>().cwiseAbs().maxCoeff();
        if (leap > 1.0) step /= leap;
        const auto next = step.allFinite() ? cost(x + step) : std::nullopt;
        better = next && *next <= *current;
        if (better) {
          x += step;
          current = next;
          damping = std::max(1e-9, 0.2 * damping);
        } else {
          damping *= 6.0;
        }
      }
      if (!better || step.cwiseAbs().maxCoeff() < kStill) break;
    }
    return x;
  }

  // Of the solution: A^-1 from edges and prior, and what pose and ground noise move it by, to first order.
  [[nodiscard]] std::optional<Mat4> covariance(const Vec4& x) const {
    const auto j = jacobian(x);
    if (!j) return std::nullopt;
    const Vec4 s = prior_slope();
    const Mat4 inverse = (j->transpose() * *j + s * s.transpose()).ldlt().solve(Mat4::Identity());
    Mat4 total = inverse;
    const auto add = [&](const std::optional<Vec4>& ahead, const std::optional<Vec4>& behind, double step,
                         double sigma) {
      if (!ahead || !behind) return false;
      const Vec4 moved = inverse * (j->transpose() * (*ahead - *behind)) * (sigma / (2.0 * step));
      total += moved * moved.transpose();
      return true;
    };
    bool known = true;
    constexpr double kStep = 1e-4;  // m, rad
    for (int axis = 0; axis < 3; ++axis) {
      RigidTransform ahead = pose_, behind = pose_;
      ahead.translation[axis] += kStep;
      behind.translation[axis] -= kStep;
      known = known &&
              add(edges(x, ahead), edges(x, behind), kStep, axis == 2 ? noise_.position_z_m : noise_.position_xy_m);
      ahead = behind = pose_;
      ahead.rotation = geometry::axis_rotation(Vec3::Unit(axis), kStep) * pose_.rotation;
      behind.rotation = geometry::axis_rotation(Vec3::Unit(axis), -kStep) * pose_.rotation;
      known = known && add(edges(x, ahead), edges(x, behind), kStep, noise_.rotation);
    }
    known = known && add(edges(x, pose_, kStep), edges(x, pose_, -kStep), kStep, noise_.ground_m);
    if (!known || !total.allFinite()) return std::nullopt;
    return Mat4(0.5 * (total + total.transpose()));
  }

 private:
  Vec4 edges_, weight_ = Vec4::Zero();
  const survey::Camera& camera_;
  RigidTransform pose_;
  GroundPlane plane_;
  const ObjectModel& model_;
  const FitNoise& noise_;
};

}  // namespace

std::optional<PixelBox> outline_box(const UprightBody& body, const survey::Camera& camera,
                                    const RigidTransform& T_world_camera) {
  constexpr std::size_t kAround = 24;
  std::array<double, kAround> u{}, v{};
  constexpr double kFar = std::numeric_limits<double>::infinity();
  PixelBox box{kFar, kFar, -kFar, -kFar};
  const RigidTransform T_camera_world = T_world_camera.inverse();
  for (const Level& level : levels_of(body.shape)) {
    const double radius = 0.5 * body.width_m * level.radius, up = body.height_m * level.height;
    for (std::size_t i = 0; i < kAround; ++i) {
      const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(kAround);
      const Vec3 p = body.foot + Vec3(radius * std::cos(angle), radius * std::sin(angle), up);
      const auto pixel = camera::project(camera, T_camera_world * p);
      if (!pixel) return std::nullopt;
      u.at(i) = pixel->x();
      v.at(i) = pixel->y();
    }
    box.xmin = std::min(box.xmin, peak(u, -1.0));
    box.xmax = std::max(box.xmax, peak(u, 1.0));
    box.ymin = std::min(box.ymin, peak(v, -1.0));
    box.ymax = std::max(box.ymax, peak(v, 1.0));
  }
  return box;
}

std::optional<BodyFit> fit_body(const PixelBox& box, const survey::Camera& camera, const RigidTransform& T_world_camera,
                                const Ground& ground, const ObjectModel& model, const FitNoise& noise,
                                double slope_base, const UprightBody& start) {
  Vec4 x(start.foot.x(), start.foot.y(), std::log(start.width_m), std::log(start.height_m));
  constexpr int kMostPlanes = 4;
  constexpr double kSettled = 1e-3;  // m
  for (int i = 0;; ++i) {
    const Problem problem(box, camera, T_world_camera, plane_at(ground, x.head<2>(), slope_base), model, noise);
    const auto solved = problem.solve(x);
    if (!solved || !solved->allFinite()) return std::nullopt;
    const double moved = (solved->head<2>() - x.head<2>()).norm();
    x = *solved;
    if (ground.terrain && moved > kSettled && i + 1 < kMostPlanes) continue;
    const auto covariance = problem.covariance(x);
    if (!covariance) return std::nullopt;
    return BodyFit{problem.body(x), *covariance};
  }
}

}  // namespace cairn::ground
