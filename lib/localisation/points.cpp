#include "localisation/points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "localisation/normal_draws.hpp"

namespace cairn::localisation {
namespace {

using geometry::Mat3;
using geometry::PixelBox;
using geometry::Vec2;
using geometry::Vec3;

constexpr Eigen::Index kBlock = 256;  // points handled at once: six arrays of a block stay in the first cache
constexpr double kNoWeight = 900.0;   // squared distance from the box's centre, sigmas^2
using Block = Eigen::Array<double, Eigen::Dynamic, 1, 0, kBlock, 1>;

// Where in a box, as fractions of its sides.
Vec2 place_in_box(BoxFill fill, base::Random& random) {
  if (fill == BoxFill::uniform) {
    const double x = random.uniform();
    return {x, random.uniform()};
  }
  // Corners in the order (0,0), (1,0), (1,1), (0,1).
  double a[4], sum = 0.0;
  do {
    sum = 0.0;
    for (double& value : a) sum += value = random.uniform();
  } while (!(sum > 0.0));
  return {(a[1] + a[2]) / sum, (a[2] + a[3]) / sum};
}

// Indices drawn with probability weight / total, one draw per point.
void draw(const std::vector<double>& weights, double total, bool systematic, base::Random& random,
          std::vector<std::uint32_t>& chosen) {
  const std::size_t m = weights.size();
  chosen.resize(m);
  if (systematic) {
    const double step = total / static_cast<double>(m);
    double at = random.uniform() * step, cumulated = weights[0];
    std::size_t index = 0;
    for (std::size_t i = 0; i < m; ++i, at += step) {
      // Rounding may leave the last position beyond the sum: the last point of positive weight takes it.
      while (cumulated < at && index + 1 < m) cumulated += weights[++index];
      chosen[i] = static_cast<std::uint32_t>(index);
    }
  } else {
    std::vector<double> cumulated(m);
    double sum = 0.0;
    for (std::size_t i = 0; i < m; ++i) cumulated[i] = sum += weights[i];
    for (auto& index : chosen) {
      const auto it = std::upper_bound(cumulated.begin(), cumulated.end(), random.uniform() * sum);
      index = static_cast<std::uint32_t>(
          std::min<std::ptrdiff_t>(it - cumulated.begin(), static_cast<std::ptrdiff_t>(m) - 1));
    }
  }
  // A trailing run of zero weights must never be chosen.
  std::size_t last = m - 1;
  while (last > 0 && !(weights[last] > 0.0)) --last;
  for (auto& index : chosen) index = std::min(index, static_cast<std::uint32_t>(last));
}

}  // namespace

Points generate_points(const View& view, const PixelBox& box, std::size_t count, const DepthRange& range, BoxFill fill,
                       base::Random& random) {
  Points points(static_cast<Eigen::Index>(count), 3);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vec2 at = place_in_box(fill, random);
    // 1 - u lies in (0, 1]: a depth of exactly 0 would put the point into the camera's centre.
    const double depth = range.near_m + (range.far_m - range.near_m) * (1.0 - random.uniform());
    const Vec2 pixel(box.xmin + at.x() * box.width(), box.ymin + at.y() * box.height());
    points.row(i) = (view.T_world_camera.translation + depth * view.direction(pixel)).transpose();
  }
  return points;
}

UpdateReport update_points(Points& points, const View& view, const PixelBox& box, const UpdateOptions& options,
                           base::Random& random) {
  UpdateReport report;
  const Eigen::Index m = points.rows();
  const double su = 0.5 * box.width(), sv = 0.5 * box.height();
  if (m == 0 || !(su > 0.0 && sv > 0.0) || !std::isfinite(su * sv)) return report;
  const Vec2 c = box.centre();
  const double peak = options.gaussian_weight / (2.0 * std::numbers::pi * su * sv);
  const double inside = options.uniform_weight / (4.0 * su * sv);
  const Mat3& R = view.T_world_camera.rotation;
  const Vec3 t = view.T_world_camera.translation;
  const double au = view.fx_px / su, bu = (view.cx_px - c.x()) / su;
  const double av = view.fy_px / sv, bv = (view.cy_px - c.y()) / sv;

  // Kept from call to call: fresh memory of this size would be mapped, and faulted in, at every update.
  thread_local Points noised;
  thread_local std::vector<double> weights;
  thread_local std::vector<std::uint32_t> chosen;
  noised.resize(m, 3);
  weights.resize(static_cast<std::size_t>(m));
  double total = 0.0, squares = 0.0;
  for (Eigen::Index begin = 0; begin < m; begin += kBlock) {
    const Eigen::Index n = std::min(kBlock, m - begin);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      double* column = noised.col(axis).data() + begin;
      fill_normal(std::span<double>(column, static_cast<std::size_t>(n)), random);
      noised.col(axis).segment(begin, n) =
          points.col(axis).segment(begin, n) + options.noise_m * noised.col(axis).segment(begin, n);
    }
    const Block x = noised.col(0).segment(begin, n).array() - t.x();
    const Block y = noised.col(1).segment(begin, n).array() - t.y();
    const Block z = noised.col(2).segment(begin, n).array() - t.z();
    const Block depth = R(0, 2) * x + R(1, 2) * y + R(2, 2) * z;
    const Block inverse = depth.inverse();
    const Block u = (R(0, 0) * x + R(1, 0) * y + R(2, 0) * z) * inverse * au + bu;  // in half widths from the centre
    const Block v = (R(0, 1) * x + R(1, 1) * y + R(2, 1) * z) * inverse * av + bv;
    const Block squared = u.square() + v.square();
    const Block density = peak * (-0.5 * squared).exp();
    for (Eigen::Index i = 0; i < n; ++i) {
      const bool behind = !(depth[i] > 0.0);
      // The vectorised exp never reaches 0: beyond 30 sigma it is taken as 0, or no box could be far enough.
      double weight =
          squared[i] > kNoWeight ? 0.0 : density[i] + (std::abs(u[i]) <= 1.0 && std::abs(v[i]) <= 1.0 ? inside : 0.0);
      if ((behind && options.cheirality) || !std::isfinite(weight)) weight = 0.0;
      report.behind += behind ? 1 : 0;
      weights[static_cast<std::size_t>(begin + i)] = weight;
      total += weight;
      squares += weight * weight;
    }
  }
  if (!(total > 0.0) || !std::isfinite(total)) return report;
  report.effective_points = squares > 0.0 ? total * total / squares : 0.0;

  draw(weights, total, options.systematic, random, chosen);
  if (options.move_points) {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double* from = noised.col(axis).data();
      double* to = points.col(axis).data();
      for (Eigen::Index i = 0; i < m; ++i) to[i] = from[chosen[static_cast<std::size_t>(i)]];
    }
  } else {
    for (Eigen::Index i = 0; i < m; ++i) noised.row(i) = points.row(chosen[static_cast<std::size_t>(i)]);
    points.swap(noised);
  }
  report.updated = true;
  return report;
}

Gaussian fit_gaussian(const Points& points) {
  Gaussian g;
  g.mean = points.colwise().mean().transpose();
  if (points.rows() < 2) return g;
  // Sums about the mean, block by block in a fixed order.
  double sums[6] = {};
  for (Eigen::Index begin = 0; begin < points.rows(); begin += kBlock) {
    const Eigen::Index n = std::min(kBlock, points.rows() - begin);
    const Block x = points.col(0).segment(begin, n).array() - g.mean.x();
    const Block y = points.col(1).segment(begin, n).array() - g.mean.y();
    const Block z = points.col(2).segment(begin, n).array() - g.mean.z();
    sums[0] += (x * x).sum();
    sums[1] += (x * y).sum();
    sums[2] += (x * z).sum();
    sums[3] += (y * y).sum();
    sums[4] += (y * z).sum();
    sums[5] += (z * z).sum();
  }
  g.covariance << sums[0], sums[1], sums[2], sums[1], sums[3], sums[4], sums[2], sums[4], sums[5];
  g.covariance /= static_cast<double>(points.rows() - 1);
  return g;
}

namespace {

struct Cholesky {
  Mat3 lower = Mat3::Zero();
  double log_det = 0.0;
};

// Of a symmetric positive definite matrix; empty where a pivot is not clearly positive.
std::optional<Cholesky> cholesky(const Mat3& a) {
  if (!a.allFinite()) return std::nullopt;
  constexpr double kRelativePivot = 1e-14;  // about the rounding of the sums that made the covariance
  Cholesky result;
  Mat3& l = result.lower;
  for (int j = 0; j < 3; ++j) {
    double pivot = a(j, j);
    for (int k = 0; k < j; ++k) pivot -= l(j, k) * l(j, k);
    if (!(pivot > kRelativePivot * a(j, j)) || !(pivot > 0.0)) return std::nullopt;
    l(j, j) = std::sqrt(pivot);
    for (int i = j + 1; i < 3; ++i) {
      double sum = a(i, j);
      for (int k = 0; k < j; ++k) sum -= l(i, k) * l(j, k);
      l(i, j) = sum / l(j, j);
    }
    result.log_det += 2.0 * std::log(l(j, j));
  }
  if (!std::isfinite(result.log_det)) return std::nullopt;
  return result;
}

}  // namespace

std::optional<double> differential_entropy(const Mat3& covariance) {
  const auto factor = cholesky(covariance);
  if (!factor) return std::nullopt;
  return 1.5 * (1.0 + std::log(2.0 * std::numbers::pi)) + 0.5 * factor->log_det;
}

std::optional<double> divergence(const Gaussian& updated, const Gaussian& previous) {
  const auto f0 = cholesky(updated.covariance), f1 = cholesky(previous.covariance);
  if (!f0 || !f1) return std::nullopt;
  // tr(P1^-1 P0) = |L1^-1 L0|^2 (Frobenius), d^T P1^-1 d = |L1^-1 d|^2.
  const auto lower = f1->lower.triangularView<Eigen::Lower>();
  const Mat3 ratio = lower.solve(f0->lower);
  const Vec3 shift = lower.solve(Vec3(updated.mean - previous.mean));
  const double d = 0.5 * (ratio.squaredNorm() + shift.squaredNorm() - 3.0 + f1->log_det - f0->log_det);
  if (!std::isfinite(d)) return std::nullopt;
  return std::max(0.0, d);
}

}  // namespace cairn::localisation
