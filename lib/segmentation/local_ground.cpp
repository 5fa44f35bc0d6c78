#include "segmentation/local_ground.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace cairn::segmentation {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

constexpr std::size_t kSectors = 8, kRings = 3;
constexpr int kRounds = 20;
constexpr double kMadToSigma = 1.4826;

// Weighted least squares z = a + b x + c y over points relative to the centre; empty when degenerate.
std::optional<Vec3> fit(const std::vector<Vec3>& relative, const std::vector<double>& weights) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < relative.size(); ++i) {
    const Vec3 row(1.0, relative[i].x(), relative[i].y());
    normal += weights[i] * row * row.transpose();
    right += weights[i] * relative[i].z() * row;
  }
  const Eigen::LDLT<Mat3> solver(normal);
  const Vec3 diagonal = solver.vectorD();
  if (solver.info() != Eigen::Success || !(diagonal.minCoeff() > 1e-9 * diagonal.maxCoeff())) return std::nullopt;
  return solver.solve(right);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::optional<GroundPlane> fit_ground(std::span<const Vec3> points, const Vec2& centre) {
  if (points.size() < 3) return std::nullopt;
  std::vector<Vec3> relative;
  relative.reserve(points.size());
  // Heights relative to one of the points too: no digits are lost to a tall datum.
  const double base = points.front().z();
  double far = 0.0, near = 1e300;
  for (const auto& p : points) {
    relative.emplace_back(p.x() - centre.x(), p.y() - centre.y(), p.z() - base);
    const double d = relative.back().head<2>().norm();
    far = std::max(far, d);
    near = std::min(near, d);
  }

  std::array<std::optional<Vec3>, kSectors * kRings> lowest;
  std::array<bool, kSectors> seen{};
  for (const auto& p : relative) {
    const double turn = (std::atan2(p.y(), p.x()) + std::numbers::pi) / (2.0 * std::numbers::pi);
    const auto sector = std::min(kSectors - 1, static_cast<std::size_t>(turn * kSectors));
    const double share = far > near ? (p.head<2>().norm() - near) / (far - near) : 0.0;
    const auto ring = std::min(kRings - 1, static_cast<std::size_t>(share * kRings));
    seen[sector] = true;
    auto& patch = lowest[sector * kRings + ring];
    if (!patch || p.z() < patch->z()) patch = p;
  }
  std::vector<Vec3> start;
  for (const auto& p : lowest)
    if (p) start.push_back(*p);
  auto plane = fit(start, std::vector<double>(start.size(), 1.0));
  if (!plane) return std::nullopt;

  std::vector<double> residual(relative.size()), weight(relative.size());
  double sigma = 0.0;
  const auto refresh = [&] {
    for (std::size_t i = 0; i < relative.size(); ++i)
      residual[i] = relative[i].z() - ((*plane)[0] + (*plane)[1] * relative[i].x() + (*plane)[2] * relative[i].y());
    std::vector<double> size(residual);
    for (double& r : size) r = std::abs(r);
    sigma = kMadToSigma * median(std::move(size));
  };
  for (int round = 0; round < kRounds; ++round) {
    refresh();
    const double scale = 2.0 * sigma + 1e-9;
    for (std::size_t i = 0; i < relative.size(); ++i) weight[i] = 1.0 / (1.0 + std::pow(residual[i] / scale, 2));
    const auto next = fit(relative, weight);
    if (!next) break;
    plane = next;
  }
  refresh();
  GroundPlane ground;
  ground.centre = centre;
  ground.up_at_centre = base + (*plane)[0];
  ground.slope = {(*plane)[1], (*plane)[2]};
  ground.noise = sigma;
  ground.points = points.size();
  ground.sectors = static_cast<std::size_t>(std::count(seen.begin(), seen.end(), true));
  return ground;
}

}  // namespace cairn::segmentation
