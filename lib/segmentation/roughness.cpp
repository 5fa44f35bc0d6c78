#include "segmentation/roughness.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"
#include "geometry/kd_tree.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec3;

constexpr std::size_t kLeastPoints = 12;
constexpr std::size_t kGrain = 64;

float residual_of(std::span<const Vec3> points, const std::vector<geometry::KdTree::Neighbour>& near) {
  if (near.size() < kLeastPoints) return std::numeric_limits<float>::quiet_NaN();
  const auto count = static_cast<double>(near.size());
  Vec3 mean = Vec3::Zero();
  for (const auto& q : near) mean += points[q.index] / count;
  geometry::Mat3 scatter = geometry::Mat3::Zero();
  for (const auto& q : near) scatter += (points[q.index] - mean) * (points[q.index] - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<geometry::Mat3> axes(scatter);
  const double scale = std::sqrt(std::max(scatter.trace() / count, 1e-300));
  using Row = Eigen::Matrix<double, 6, 1>;
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Row right = Row::Zero();
  double squares = 0.0;
  for (const auto& q : near) {
    const Vec3 local = axes.eigenvectors().transpose() * (points[q.index] - mean) / scale;
    const double a = local[2], b = local[1], z = local[0];
    Row row;
    row << 1.0, a, b, a * a, a * b, b * b;
    normal.selfadjointView<Eigen::Lower>().rankUpdate(row);
    right += z * row;
    squares += z * z;
  }
  const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(normal.selfadjointView<Eigen::Lower>());
  const double left = std::max(0.0, squares - right.dot(solver.solve(right)));
  return static_cast<float>(scale * std::sqrt(left / std::max(1.0, count - 6.0)));
}

}  // namespace

std::vector<float> skin_residuals(std::span<const Vec3> places, std::span<const Vec3> points, double reach) {
  const geometry::KdTree tree(points);
  std::vector<float> residuals(places.size());
  base::parallel_for(places.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) residuals[i] = residual_of(points, tree.within(places[i], reach));
  });
  return residuals;
}

double residual_quantile(std::vector<float> residuals, double quantile) {
  std::erase_if(residuals, [](float r) { return !std::isfinite(r); });
  if (residuals.empty()) return 0.0;
  const auto at = residuals.begin() + static_cast<std::ptrdiff_t>(quantile * static_cast<double>(residuals.size() - 1));
  std::nth_element(residuals.begin(), at, residuals.end());
  return static_cast<double>(*at);
}

}  // namespace cairn::segmentation
