#include "planning/minimum_snap.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"

namespace cairn::planning {
namespace {

constexpr int kCoefficients = 10;
constexpr int kOrders = 5;  // value and four derivatives at each end fix the ten coefficients
constexpr int kFree = 4;    // derivatives 1..4 of an inner key

using Mat10 = Eigen::Matrix<double, kCoefficients, kCoefficients>;
using Mat4 = Eigen::Matrix4d;

double falling(int n, int k) {
  double product = 1.0;
  for (int i = 0; i < k; ++i) product *= n - i;
  return product;
}

// On a segment of unit duration.
struct UnitSegment {
  Mat10 from_ends;  // derivatives 0..4 at 0, then at 1 -> coefficients
  Mat10 cost;       // quadratic form of those derivatives: integral of the squared fourth derivative

  UnitSegment() {
    Mat10 ends = Mat10::Zero(), snap = Mat10::Zero();
    for (int order = 0; order < kOrders; ++order)
      for (int c = order; c < kCoefficients; ++c) {
        if (c == order) ends(order, c) = falling(c, order);
        ends(kOrders + order, c) = falling(c, order);
      }
    for (int i = 4; i < kCoefficients; ++i)
      for (int j = 4; j < kCoefficients; ++j) snap(i, j) = falling(i, 4) * falling(j, 4) / (i + j - 7);
    from_ends = ends.inverse();
    cost = from_ends.transpose() * snap * from_ends;
  }
};

const UnitSegment& unit() {
  static const UnitSegment segment;
  return segment;
}

// In real time: derivative i of a unit segment is T^i times that of the segment; the integral gains T^-7.
Mat10 cost_of(double T) {
  Eigen::Matrix<double, kCoefficients, 1> scale;
  for (int i = 0; i < kOrders; ++i) scale(i) = scale(kOrders + i) = std::pow(T, i);
  return std::pow(T, -7) * (scale.asDiagonal() * unit().cost * scale.asDiagonal());
}

// Values (row 0) and derivatives 1..4 of the four coordinates at one key.
using KeyState = Eigen::Matrix<double, kOrders, 4>;

survey::PolynomialSegment segment_between(const KeyState& a, const KeyState& b, double T) {
  Eigen::Matrix<double, kCoefficients, 4> ends;
  for (int i = 0; i < kOrders; ++i) {
    ends.row(i) = std::pow(T, i) * a.row(i);
    ends.row(kOrders + i) = std::pow(T, i) * b.row(i);
  }
  // Relative to the first end, so that no digits go where the coordinates are large.
  const Eigen::RowVector4d base = a.row(0);
  ends.row(0) -= base;
  ends.row(kOrders) -= base;
  const Eigen::Matrix<double, kCoefficients, 4> unit_coefficients = unit().from_ends * ends;
  survey::PolynomialSegment segment;
  segment.duration_s = T;
  for (std::size_t d = 0; d < 4; ++d)
    for (std::size_t c = 0; c < kCoefficients; ++c)
      segment.coefficients[d][c] = unit_coefficients(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(d)) *
                                       std::pow(T, -static_cast<double>(c)) +
                                   (c == 0 ? base(static_cast<Eigen::Index>(d)) : 0.0);
  return segment;
}

void check(std::span<const Pose4> keys, std::span<const double> durations) {
  const auto refuse = [](std::string found, std::string allowed) {
    throw base::Error(base::ErrorCode::invalid_argument, "no trajectory through these keys")
        .found(found)
        .allowed(allowed);
  };
  if (keys.size() < 2 || durations.size() + 1 != keys.size())
    refuse(std::to_string(keys.size()) + " keys and " + std::to_string(durations.size()) + " durations",
           "2 keys or more and one duration between each two");
  for (const Pose4& key : keys)
    if (!key.allFinite()) refuse("a key that is not finite", "finite coordinates");
  for (const double T : durations)
    if (!(T > 0.0) || !std::isfinite(T)) refuse("a duration of " + std::to_string(T) + " s", "above 0");
}

}  // namespace

std::vector<survey::PolynomialSegment> minimum_snap(std::span<const Pose4> keys, std::span<const double> durations,
                                                    const StartState& start) {
  check(keys, durations);
  const std::size_t n = keys.size();
  // In units of the mean duration the blocks are of one size.
  double unit_s = 0.0;
  for (const double T : durations) unit_s += T / static_cast<double>(durations.size());
  std::vector<KeyState> state(n, KeyState::Zero());
  for (std::size_t i = 0; i < n; ++i) state[i].row(0) = (keys[i] - keys[0]).transpose();
  state[0].row(1) = unit_s * start.velocity.transpose();

  // Inner keys 1..n-2: diagonal blocks, blocks to the next key, right-hand sides.
  const std::size_t inner = n - 2;
  std::vector<Mat4> diagonal(inner, Mat4::Zero()), next(inner, Mat4::Zero()), right(inner, Mat4::Zero());
  for (std::size_t s = 0; s + 1 < n; ++s) {
    const Mat10 cost = cost_of(durations[s] / unit_s);
    const auto block = [&](int row, int column) -> Mat4 { return cost.block<kFree, kFree>(row, column); };
    constexpr int a = 1, b = kOrders + 1;  // rows of the derivatives at the first and the second key
    const Mat4 from_values_a =
        cost.block<kFree, 1>(a, 0) * state[s].row(0) + cost.block<kFree, 1>(a, kOrders) * state[s + 1].row(0);
    const Mat4 from_values_b =
        cost.block<kFree, 1>(b, 0) * state[s].row(0) + cost.block<kFree, 1>(b, kOrders) * state[s + 1].row(0);
    if (s >= 1) {
      diagonal[s - 1] += block(a, a);
      right[s - 1] -= from_values_a;
    }
    if (s + 2 < n) {
      diagonal[s] += block(b, b);
      right[s] -= from_values_b;
    }
    if (s >= 1 && s + 2 < n) next[s - 1] = block(a, b);
    if (s == 0 && inner > 0) right[0] -= block(b, a) * state[0].block<kFree, 4>(1, 0);
  }
  for (std::size_t i = 0; i + 1 < inner; ++i) {
    const Mat4 factor = diagonal[i].llt().solve(next[i]).transpose();
    diagonal[i + 1] -= factor * next[i];
    right[i + 1] -= factor * right[i];
  }
  for (std::size_t i = inner; i-- > 0;) {
    if (i + 1 < inner) right[i] -= next[i] * state[i + 2].block<kFree, 4>(1, 0);
    state[i + 1].block<kFree, 4>(1, 0) = diagonal[i].llt().solve(right[i]);
  }

  for (KeyState& at : state)
    for (int order = 1; order < kOrders; ++order) at.row(order) *= std::pow(unit_s, -order);

  std::vector<survey::PolynomialSegment> trajectory;
  trajectory.reserve(n - 1);
  for (std::size_t s = 0; s + 1 < n; ++s) {
    trajectory.push_back(segment_between(state[s], state[s + 1], durations[s]));
    for (std::size_t d = 0; d < 4; ++d) trajectory.back().coefficients[d][0] += keys[0](static_cast<Eigen::Index>(d));
  }
  return trajectory;
}

Pose4 evaluate(const survey::PolynomialSegment& segment, double t, int derivative) {
  Pose4 value = Pose4::Zero();
  for (std::size_t d = 0; d < 4; ++d) {
    double sum = 0.0;
    for (int c = kCoefficients - 1; c >= derivative; --c)
      sum = sum * t + falling(c, derivative) * segment.coefficients[d][static_cast<std::size_t>(c)];
    value(static_cast<Eigen::Index>(d)) = sum;
  }
  return value;
}

Pose4 evaluate(std::span<const survey::PolynomialSegment> trajectory, double t, int derivative) {
  if (trajectory.empty()) return Pose4::Zero();
  t = std::max(t, 0.0);
  std::size_t s = 0;
  while (s + 1 < trajectory.size() && t > trajectory[s].duration_s) t -= trajectory[s++].duration_s;
  return evaluate(trajectory[s], std::min(t, trajectory[s].duration_s), derivative);
}

double duration(std::span<const survey::PolynomialSegment> trajectory) {
  double sum = 0.0;
  for (const auto& segment : trajectory) sum += segment.duration_s;
  return sum;
}

}  // namespace cairn::planning
