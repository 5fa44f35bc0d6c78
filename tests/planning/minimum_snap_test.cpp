#include "planning/minimum_snap.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <cmath>

#include "base/error.hpp"
#include "base/random.hpp"

namespace {

using cairn::planning::duration;
using cairn::planning::evaluate;
using cairn::planning::minimum_snap;
using cairn::planning::Pose4;
using Trajectory = std::vector<cairn::survey::PolynomialSegment>;

constexpr double kExact = 1e-9;  // m, m/s ...: rounding of polynomials of degree 9

std::vector<Pose4> random_keys(std::size_t n, std::uint64_t record) {
  cairn::base::Random random(5, "keys", record);
  std::vector<Pose4> keys;
  for (std::size_t i = 0; i < n; ++i)
    keys.emplace_back(random.uniform(-20, 20), random.uniform(-20, 20), random.uniform(0, 20), random.uniform(-3, 3));
  return keys;
}

// Integral of |fourth derivative|^2 by Simpson's rule, which is exact enough for degree 10.
double snap(const Trajectory& trajectory) {
  double sum = 0.0;
  for (const auto& s : trajectory) {
    constexpr int n = 400;
    for (int i = 0; i <= n; ++i) {
      const double weight = i == 0 || i == n ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
      sum += weight * evaluate(s, s.duration_s * i / n, 4).squaredNorm() * s.duration_s / (3.0 * n);
    }
  }
  return sum;
}

TEST(MinimumSnap, PassesItsKeysAtRestAtBothEndsAndSmoothBetween) {
  const auto keys = random_keys(7, 0);
  const std::vector<double> durations{2.0, 1.0, 3.5, 0.7, 2.2, 4.0};
  const auto trajectory = minimum_snap(keys, durations);
  ASSERT_EQ(trajectory.size(), durations.size());
  EXPECT_DOUBLE_EQ(duration(trajectory), 13.4);
  for (std::size_t s = 0; s < trajectory.size(); ++s) {
    EXPECT_LT((evaluate(trajectory[s], 0.0) - keys[s]).norm(), kExact);
    EXPECT_LT((evaluate(trajectory[s], durations[s]) - keys[s + 1]).norm(), 1e3 * kExact);
    if (s == 0) continue;
    for (int order = 1; order <= 4; ++order) {
      const Pose4 before = evaluate(trajectory[s - 1], durations[s - 1], order),
                  after = evaluate(trajectory[s], 0, order);
      EXPECT_LT((before - after).norm(), 1e-6 * std::max(1.0, after.norm())) << "order " << order << " at key " << s;
    }
  }
  for (int order = 1; order <= 4; ++order) {
    EXPECT_LT(evaluate(trajectory.front(), 0.0, order).norm(), kExact);
    EXPECT_LT(evaluate(trajectory.back(), durations.back(), order).norm(), 1e-5);
  }
}

// With derivatives 1..4 zero at both ends the ten conditions leave one polynomial: the smooth step of degree 9.
TEST(MinimumSnap, OneSegmentIsTheSmoothStep) {
  const std::vector<Pose4> keys{{0, 0, 0, 0}, {10, -5, 2, 1}};
  const auto trajectory = minimum_snap(keys, std::vector<double>{4.0});
  for (const double t : {0.1, 0.25, 0.5, 0.8}) {
    const double step = std::pow(t, 5) * (126 - 420 * t + 540 * t * t - 315 * t * t * t + 70 * t * t * t * t);
    EXPECT_LT((evaluate(trajectory[0], 4.0 * t) - keys[1] * step).norm(), kExact) << t;
  }
}

// The same problem written out in full: ten coefficients a segment as unknowns, the conditions as Lagrange multipliers,
// one dense system.
std::vector<Eigen::VectorXd> dense_solution(const std::vector<Pose4>& keys, const std::vector<double>& T) {
  const auto n = static_cast<Eigen::Index>(T.size());
  const auto falling = [](int k, int order) {
    double product = 1.0;
    for (int i = 0; i < order; ++i) product *= k - i;
    return product;
  };
  Eigen::MatrixXd cost = Eigen::MatrixXd::Zero(10 * n, 10 * n);
  for (Eigen::Index s = 0; s < n; ++s)
    for (int i = 4; i < 10; ++i)
      for (int j = 4; j < 10; ++j)
        cost(10 * s + i, 10 * s + j) =
            falling(i, 4) * falling(j, 4) * std::pow(T[static_cast<std::size_t>(s)], i + j - 7) / (i + j - 7);
  std::vector<Eigen::RowVectorXd> rows;
  std::vector<Pose4> wanted;
  const auto derivative_at = [&](Eigen::Index s, double t, int order) {
    Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(10 * n);
    for (int k = order; k < 10; ++k) row(10 * s + k) = falling(k, order) * std::pow(t, k - order);
    return row;
  };
  const auto ask = [&](const Eigen::RowVectorXd& row, const Pose4& value) {
    rows.push_back(row);
    wanted.push_back(value);
  };
  for (Eigen::Index s = 0; s < n; ++s) {
    const double end = T[static_cast<std::size_t>(s)];
    ask(derivative_at(s, 0.0, 0), keys[static_cast<std::size_t>(s)]);
    ask(derivative_at(s, end, 0), keys[static_cast<std::size_t>(s) + 1]);
    for (int order = 1; order <= 4; ++order) {
      if (s == 0) ask(derivative_at(s, 0.0, order), Pose4::Zero());
      ask(derivative_at(s, end, order) -
              (s + 1 < n ? derivative_at(s + 1, 0.0, order) : Eigen::RowVectorXd::Zero(10 * n)),
          Pose4::Zero());
    }
  }
  const auto m = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(10 * n + m, 10 * n + m), right = Eigen::MatrixXd::Zero(10 * n + m, 4);
  system.topLeftCorner(10 * n, 10 * n) = cost;
  for (Eigen::Index r = 0; r < m; ++r) {
    system.row(10 * n + r).head(10 * n) = rows[static_cast<std::size_t>(r)];
    system.col(10 * n + r).head(10 * n) = rows[static_cast<std::size_t>(r)].transpose();
    right.row(10 * n + r) = wanted[static_cast<std::size_t>(r)].transpose();
  }
  const Eigen::MatrixXd x = system.fullPivLu().solve(right);
  std::vector<Eigen::VectorXd> coordinates;
  for (int d = 0; d < 4; ++d) coordinates.emplace_back(x.col(d).head(10 * n));
  return coordinates;
}

TEST(MinimumSnap, EqualsTheConstrainedLeastProblemSolvedInFull) {
  for (std::uint64_t run = 0; run < 5; ++run) {
    cairn::base::Random random(6, "durations", run);
    const auto keys = random_keys(4, 10 + run);
    const std::vector<double> durations{random.uniform(0.8, 2), random.uniform(0.8, 2), random.uniform(0.8, 2)};
    const auto trajectory = minimum_snap(keys, durations);
    const auto dense = dense_solution(keys, durations);
    for (std::size_t s = 0; s < 3; ++s)
      for (double t = 0.0; t <= durations[s]; t += 0.1)
        for (Eigen::Index d = 0; d < 4; ++d) {
          double value = 0.0;
          for (int k = 9; k >= 0; --k)
            value = value * t + dense[static_cast<std::size_t>(d)](static_cast<Eigen::Index>(10 * s) + k);
          constexpr double kDense = 1e-5;  // m: the dense system is badly conditioned
          EXPECT_NEAR(evaluate(trajectory[s], t)(d), value, kDense) << "run " << run << " segment " << s << " t " << t;
        }
  }
}

// Another key on the trajectory frees the curve there: its snap can only fall; through a point beside it, it rises
// above that.
TEST(MinimumSnap, MoreKeysOnTheTrajectoryNeverCostMore) {
  const auto keys = random_keys(4, 1);
  const auto whole = minimum_snap(keys, std::vector<double>{3.0, 2.0, 2.5});
  std::vector<Pose4> more = keys;
  more.insert(more.begin() + 2, evaluate(whole[1], 0.8));
  EXPECT_LE(snap(minimum_snap(more, std::vector<double>{3.0, 0.8, 1.2, 2.5})), snap(whole) * (1 + 1e-9));
}

TEST(MinimumSnap, StartsWithAGivenVelocityAndFarFromTheOrigin) {
  auto keys = random_keys(3, 3);
  for (auto& key : keys) key += Pose4(5000, -8000, 300, 40);
  const auto trajectory = minimum_snap(keys, std::vector<double>{3.0, 3.0}, {Pose4(0.5, -0.2, 0.1, 0.0)});
  EXPECT_LT((evaluate(trajectory[0], 0.0, 1) - Pose4(0.5, -0.2, 0.1, 0.0)).norm(), kExact);
  EXPECT_LT((evaluate(trajectory[1], 3.0) - keys[2]).norm(), 1e-7);
  EXPECT_LT((evaluate(trajectory[0], 3.0, 2) - evaluate(trajectory[1], 0.0, 2)).norm(), 1e-7);
}

TEST(MinimumSnap, RefusesWhatIsNoTrajectory) {
  const std::vector<Pose4> keys{{0, 0, 0, 0}, {1, 0, 0, 0}};
  EXPECT_THROW(static_cast<void>(minimum_snap(keys, std::vector<double>{0.0})), cairn::base::Error);
  EXPECT_THROW(static_cast<void>(minimum_snap(keys, std::vector<double>{1.0, 1.0})), cairn::base::Error);
  EXPECT_THROW(static_cast<void>(minimum_snap(std::vector<Pose4>{keys[0]}, std::vector<double>{})), cairn::base::Error);
  EXPECT_THROW(
      static_cast<void>(minimum_snap(std::vector<Pose4>{keys[0], {0, std::nan(""), 0, 0}}, std::vector<double>{1.0})),
      cairn::base::Error);
}

}  // namespace
