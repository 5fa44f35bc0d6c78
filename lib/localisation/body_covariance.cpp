#include "localisation/body_work.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "geometry/enclosing_circle.hpp"

namespace cairn::localisation {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

geometry::VerticalCylinder cylinder_of(const Body& body) {
  // A support's derivative along the angle is how far its point of contact lies to the side.
  constexpr int kDirections = 60;
  constexpr double kTurn = 2.0 * std::numbers::pi / kDirections;
  std::array<double, kDirections> h;
  const auto along = [](int i) { return Vec2(std::cos(kTurn * i), std::sin(kTurn * i)); };
  for (int i = 0; i < kDirections; ++i) {
    const Vec2 u = along(i);
    h[static_cast<std::size_t>(i)] = body.support(Vec3(u.x(), u.y(), 0.0));
  }
  const auto at = [&](int i) { return h[static_cast<std::size_t>((i + kDirections) % kDirections)]; };
  std::vector<Vec2> touched;
  for (int i = 0; i < kDirections; ++i) {
    const double aside = (8.0 * (at(i + 1) - at(i - 1)) - (at(i + 2) - at(i - 2))) / (12.0 * kTurn);
    const Vec2 u = along(i);
    touched.push_back(at(i) * u + aside * Vec2(-u.y(), u.x()));
  }
  const auto circle = geometry::smallest_enclosing_circle(touched);
  geometry::VerticalCylinder cylinder;
  cylinder.axis = circle.centre + Vec2(body.ellipsoid[kCentreEast], body.ellipsoid[kCentreNorth]);
  cylinder.radius = circle.radius;
  cylinder.bottom = body.ellipsoid[kCentreUp] - body.support(Vec3(0.0, 0.0, -1.0));
  cylinder.top = body.ellipsoid[kCentreUp] + body.support(Vec3(0.0, 0.0, 1.0));
  return cylinder;
}

namespace {

Body moved(const Body& body, const BodyVector& by) {
  Body result = body;
  for (std::size_t i = 0; i < kEllipsoidParameters; ++i) result.ellipsoid[i] += by[static_cast<Eigen::Index>(i)];
  for (std::size_t i = 0; i < kHarmonics; ++i)
    result.harmonic[i] += by[static_cast<Eigen::Index>(kEllipsoidParameters + i)];
  return result;
}

// Covariance of the cylinder's centre from that of the parameters: differences over one sigma along each column of its
// root, because the smallest circle is only piecewise smooth.
Mat3 centre_covariance(const Body& body, const BodyMatrix& covariance) {
  const BodyMatrix root = covariance.llt().matrixL();
  Mat3 result = Mat3::Zero();
  for (Eigen::Index i = 0; i < root.cols(); ++i) {
    const Vec3 d =
        0.5 * (cylinder_of(moved(body, root.col(i))).centre() - cylinder_of(moved(body, -root.col(i))).centre());
    result += d * d.transpose();
  }
  return result;
}

// Empty with fewer stretches than kLeastBlocks.
std::optional<BodyMatrix> block_covariance(const BodyWork& work) {
  constexpr std::int64_t kLongest_ns = 10'000'000'000, kPause_ns = 2'000'000'000;
  constexpr std::size_t kLeastBlocks = 8;
  const auto& s = work.solution;
  BodyMatrix prior = s.normal, squares = BodyMatrix::Zero();
  BodyVector sum = BodyVector::Zero();
  std::size_t blocks = 1;
  std::int64_t begin = work.boxes.empty() ? 0 : work.boxes.front().time_ns;
  for (std::size_t i = 0; i < work.boxes.size(); ++i) {
    const std::int64_t now = work.boxes[i].time_ns;
    if (i > 0 && (now - begin > kLongest_ns || now - work.boxes[i - 1].time_ns > kPause_ns)) {
      squares += sum * sum.transpose();
      sum.setZero();
      ++blocks;
      begin = now;
    }
    const Eigen::Matrix4d& whitener = work.boxes[i].planes.whitener;
    const SideJacobian whitened = whitener * s.jacobian[i];
    sum += s.weight[i] * whitened.transpose() * (whitener * s.residual[i]);
    prior -= s.weight[i] * whitened.transpose() * whitened;
  }
  if (blocks < kLeastBlocks) return std::nullopt;
  squares += sum * sum.transpose();
  const double few = static_cast<double>(blocks) / static_cast<double>(blocks - 1);
  const BodyMatrix inverse = s.normal.llt().solve(BodyMatrix::Identity());
  return BodyMatrix(inverse * (few * squares + prior) * inverse);
}

}  // namespace

CentreCovariance centre_covariance(const BodyWork& work) {
  const auto& s = work.solution;
  CentreCovariance result;
  if (!work.reason.empty() || !s.failure.empty()) return result;
  result.value = centre_covariance(s.body, s.normal.llt().solve(BodyMatrix::Identity()));
  if (const auto blocks = block_covariance(work)) {
    const Mat3 seen = centre_covariance(s.body, *blocks);
    const double ratio = std::sqrt(seen.trace() / result.value.trace());
    if (seen.allFinite() && std::isfinite(ratio)) {
      result.value = seen;
      result.slow = ratio;
    }
  }
  return result;
}

double common_turn(const std::vector<CentreCovariance>& covariances, const BodyFitOptions& options) {
  std::vector<double> slow;
  for (const auto& c : covariances)
    if (c.slow) slow.push_back(*c.slow);
  if (slow.empty()) return options.common_turn;
  const auto middle = slow.begin() + static_cast<std::ptrdiff_t>(slow.size() / 2);
  std::nth_element(slow.begin(), middle, slow.end());
  constexpr double kWhenNew = 0.1, kSlope = 0.7, kMost = 0.5;
  return std::clamp(kWhenNew + kSlope * (*middle - 1.0), std::min(kWhenNew, options.common_turn), kMost);
}

}  // namespace cairn::localisation
