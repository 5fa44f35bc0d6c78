#include "localisation/triangulation.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::localisation {
namespace {

using geometry::Mat2;
using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;
using Jacobian = Eigen::Matrix<double, 2, 3>;

constexpr std::size_t kMostPairs = 60;
constexpr std::size_t kMostForStart = 64;  // sightings: more do not make the start better
constexpr int kSteps = 25;
constexpr double kStepTolerance = 1e-9;    // m
constexpr double kHuber = 1.345;           // sigmas: 95 % efficiency for normal errors
constexpr double kLeastSine = 8.7e-4;      // 0.05 deg between two rays
constexpr double kLeastCondition = 1e-12;  // smallest / largest eigenvalue of the normal matrix

struct Residual {
  Vec2 value;
  Jacobian jacobian;
  Mat2 covariance;
};

// Pixel of a point, its derivative, and what the pose's errors do to it.
std::optional<Residual> projected(const FrameView& frame, const Vec3& point) {
  const View& view = frame.view;
  const Vec3 p = view.to_camera(point);
  if (!(p.z() > 0.0)) return std::nullopt;
  Residual r;
  r.value = Vec2(view.fx_px * p.x() / p.z() + view.cx_px, view.fy_px * p.y() / p.z() + view.cy_px);
  r.jacobian = view.jacobian(p);
  const Vec3 position(frame.sigma_xy_m * frame.sigma_xy_m, frame.sigma_xy_m * frame.sigma_xy_m,
                      frame.sigma_z_m * frame.sigma_z_m);
  r.covariance = r.jacobian * position.asDiagonal() * r.jacobian.transpose();
  if (frame.sigma_rot_rad > 0.0) {
    // A turn of the camera by w moves the point by w x (point - centre).
    const Vec3 arm = point - view.T_world_camera.translation;
    Mat3 cross;
    cross << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
    const Jacobian turn = r.jacobian * cross;
    r.covariance += frame.sigma_rot_rad * frame.sigma_rot_rad * turn * turn.transpose();
  }
  if (!r.value.allFinite() || !r.covariance.allFinite()) return std::nullopt;
  return r;
}

// Residual of a sighting at a point, with the errors of box and pose.
std::optional<Residual> residual(const Sighting& s, const Vec3& point) {
  auto r = projected(*s.frame, point);
  if (!r) return std::nullopt;
  r->value -= s.centre_px;
  r->covariance += s.sigma_px.cwiseAbs2().asDiagonal();
  return r;
}

std::optional<double> squared_norm(const Vec2& value, const Mat2& covariance) {
  const double det = covariance(0, 0) * covariance(1, 1) - covariance(0, 1) * covariance(1, 0);
  if (!(det > 0.0)) return std::nullopt;
  const double d = (covariance(1, 1) * value.x() * value.x() - 2.0 * covariance(0, 1) * value.x() * value.y() +
                    covariance(0, 0) * value.y() * value.y()) /
                   det;
  if (!std::isfinite(d)) return std::nullopt;
  return d;
}

// Which sightings lie within the gate of a point of the given covariance. cost: sum of squared distances, capped.
std::vector<bool> agreeing(std::span<const Sighting> sightings, const Meeting& at, double gate, double* cost) {
  std::vector<bool> inlier(sightings.size(), false);
  *cost = 0.0;
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    const auto d = squared_distance(sightings[i], at.point, at.covariance);
    inlier[i] = d && *d <= gate * gate;
    *cost += inlier[i] ? *d : gate * gate;
  }
  return inlier;
}

std::size_t whole(std::span<const Sighting> sightings, const std::vector<bool>& inlier) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < sightings.size(); ++i)
    if (inlier[i] && !sightings[i].cut) ++count;
  return count;
}

bool invertible(const Mat3& normal) {
  const double largest = normal.diagonal().maxCoeff();
  return normal.allFinite() && largest > 0.0 && normal.determinant() > kLeastCondition * largest * largest * largest;
}

struct Solution {
  Vec3 point;
  Mat3 covariance;
};

// Gauss-Newton over the marked sightings. The final covariance is without Huber's weights: the marked
// sightings are taken as good.
std::optional<Solution> solve(std::span<const Sighting> sightings, const std::vector<bool>& use, Vec3 point) {
  Mat3 information = Mat3::Zero();
  for (int step = 0; step < kSteps; ++step) {
    Mat3 normal = Mat3::Zero();
    Vec3 gradient = Vec3::Zero();
    information.setZero();
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      if (!use[i]) continue;
      const auto r = residual(sightings[i], point);
      if (!r) return std::nullopt;
      const auto d2 = squared_norm(r->value, r->covariance);
      if (!d2) return std::nullopt;
      const double d = std::sqrt(*d2);
      const double weight = d > kHuber ? kHuber / d : 1.0;
      const Mat2 inverse = r->covariance.inverse();
      const Mat3 contribution = r->jacobian.transpose() * inverse * r->jacobian;
      information += contribution;
      normal += weight * contribution;
      gradient += weight * (r->jacobian.transpose() * (inverse * r->value));
    }
    if (!invertible(normal)) return std::nullopt;
    const Vec3 move = -normal.ldlt().solve(gradient);
    if (!move.allFinite()) return std::nullopt;
    point += move;
    if (move.norm() < kStepTolerance) break;
  }
  if (!invertible(information)) return std::nullopt;
  const Mat3 covariance = information.inverse();
  if (!covariance.allFinite() || !point.allFinite()) return std::nullopt;
  return Solution{point, 0.5 * (covariance + covariance.transpose())};
}

}  // namespace

std::optional<Appearance> appearance(const FrameView& frame, const Vec3& point, const Mat3& covariance) {
  const auto r = projected(frame, point);
  if (!r) return std::nullopt;
  Appearance at{r->value, r->covariance + r->jacobian * covariance * r->jacobian.transpose(),
                frame.view.to_camera(point).z()};
  if (!at.covariance.allFinite()) return std::nullopt;
  return at;
}

double squared_distance(const Appearance& at, const Vec2& centre_px, const Vec2& sigma_px) {
  Mat2 covariance = at.covariance;
  covariance.diagonal() += sigma_px.cwiseAbs2();
  return squared_norm(at.pixel - centre_px, covariance).value_or(std::numeric_limits<double>::infinity());
}

double widest_angle(std::span<const Vec3> directions) {
  constexpr std::size_t kExact = 64;
  constexpr int kSweeps = 4;
  const auto angle = [](const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); };
  double widest = 0.0;
  if (directions.size() <= kExact) {
    for (std::size_t i = 0; i < directions.size(); ++i)
      for (std::size_t j = i + 1; j < directions.size(); ++j)
        widest = std::max(widest, angle(directions[i], directions[j]));
    return widest;
  }
  std::size_t from = 0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    std::size_t farthest = from;
    double least = 2.0;
    for (std::size_t i = 0; i < directions.size(); ++i)
      if (const double dot = directions[from].dot(directions[i]); dot < least) {
        least = dot;
        farthest = i;
      }
    widest = std::max(widest, angle(directions[from], directions[farthest]));
    from = farthest;
  }
  return widest;
}

std::optional<double> squared_distance(const Sighting& sighting, const Vec3& point, const Mat3& covariance) {
  const auto r = residual(sighting, point);
  if (!r) return std::nullopt;
  return squared_norm(r->value, r->covariance + r->jacobian * covariance * r->jacobian.transpose());
}

std::optional<Meeting> intersect(const Sighting& a, const Sighting& b) {
  const Vec3 oa = a.frame->view.T_world_camera.translation, ob = b.frame->view.T_world_camera.translation;
  const Vec3 da = a.frame->view.direction(a.centre_px).normalized();
  const Vec3 db = b.frame->view.direction(b.centre_px).normalized();
  const Vec3 between = ob - oa;
  const double c = da.dot(db), s2 = 1.0 - c * c;
  if (!(s2 > kLeastSine * kLeastSine)) return std::nullopt;
  const double ta = (between.dot(da) - c * between.dot(db)) / s2;
  const double tb = (c * between.dot(da) - between.dot(db)) / s2;
  if (!(ta > 0.0 && tb > 0.0)) return std::nullopt;
  Meeting meeting;
  meeting.point = 0.5 * (oa + ta * da + ob + tb * db);
  if (!meeting.point.allFinite()) return std::nullopt;
  Mat3 information = Mat3::Zero();
  for (const Sighting* s : {&a, &b}) {
    const auto r = residual(*s, meeting.point);
    if (!r) return std::nullopt;
    information += r->jacobian.transpose() * r->covariance.inverse() * r->jacobian;
  }
  if (!invertible(information)) return std::nullopt;
  meeting.covariance = information.inverse();
  return meeting;
}

std::optional<Triangulation> triangulate(std::span<const Sighting> all, const TriangulationOptions& options) {
  const std::size_t least = std::max<std::size_t>(2, options.least);
  if (all.size() < least) return std::nullopt;
  std::vector<Sighting> some;
  if (all.size() > kMostForStart)
    for (std::size_t i = 0; i < kMostForStart; ++i) some.push_back(all[i * (all.size() - 1) / (kMostForStart - 1)]);
  const std::span<const Sighting> sightings = some.empty() ? all : std::span<const Sighting>(some);
  const std::size_t n = sightings.size();

  // Best of the pair intersections.
  const std::size_t pairs = n * (n - 1) / 2;
  const std::size_t stride = (pairs + kMostPairs - 1) / kMostPairs;
  std::optional<Vec3> start;
  double best = 0.0;
  std::size_t pair = 0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j, ++pair) {
      if (pair % stride != 0 || sightings[i].cut || sightings[j].cut) continue;
      const auto meeting = intersect(sightings[i], sightings[j]);
      if (!meeting) continue;
      // The pair itself must agree without the benefit of its own uncertainty.
      const auto di = squared_distance(sightings[i], meeting->point, Mat3::Zero());
      const auto dj = squared_distance(sightings[j], meeting->point, Mat3::Zero());
      if (!di || !dj || *di > options.gate * options.gate || *dj > options.gate * options.gate) continue;
      double cost = 0.0;
      const auto agree = agreeing(sightings, *meeting, options.gate, &cost);
      if (start && cost >= best) continue;
      if (const auto solution = solve(sightings, agree, meeting->point)) {
        start = solution->point;
        best = cost;
      }
    }
  if (!start) return std::nullopt;
  return triangulate_from(*start, all, options);
}

std::optional<Triangulation> triangulate_from(const Vec3& start, std::span<const Sighting> sightings,
                                              const TriangulationOptions& options) {
  const std::size_t n = sightings.size();
  const std::size_t least = std::max<std::size_t>(2, options.least);
  double cost = 0.0;
  std::vector<bool> inlier = agreeing(sightings, {start, Mat3::Zero()}, options.gate, &cost);
  std::optional<Solution> solution;
  for (int round = 0; round < 3; ++round) {
    if (whole(sightings, inlier) < least) return std::nullopt;
    solution = solve(sightings, inlier, solution ? solution->point : start);
    if (!solution) return std::nullopt;
    auto again = agreeing(sightings, {solution->point, Mat3::Zero()}, options.gate, &cost);
    if (again == inlier) break;
    inlier = std::move(again);
  }

  Triangulation result;
  result.centre = solution->point;
  result.covariance = solution->covariance;
  result.inlier = inlier;
  double squares = 0.0;
  std::vector<Vec3> directions;
  for (std::size_t i = 0; i < n; ++i) {
    if (!inlier[i]) continue;
    ++result.inliers;
    if (const auto r = residual(sightings[i], result.centre)) squares += r->value.squaredNorm();
    directions.push_back((result.centre - sightings[i].frame->view.T_world_camera.translation).normalized());
  }
  if (whole(sightings, inlier) < least) return std::nullopt;
  result.rms_px = std::sqrt(squares / static_cast<double>(result.inliers));
  result.parallax_rad = widest_angle(directions);
  return result;
}

}  // namespace cairn::localisation
