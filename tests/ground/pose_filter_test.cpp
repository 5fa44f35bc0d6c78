#include "ground/pose_filter.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.hpp"
#include "ground/pose_run.hpp"
#include "support/ground_drive.hpp"

namespace {

using namespace cairn;
using geometry::Mat2;
using geometry::Vec2;
using ground::PoseFilter;
using ground::PoseFilterOptions;
using survey::VehicleState;

constexpr std::int64_t kStep_ns = 20'000'000;
constexpr double kRounding_m = 1e-9;  // sums of a thousand steps

VehicleState sample(std::int64_t time_ns, const Vec2& position, const Vec2& velocity, double sigma_m = 0.0) {
  VehicleState s;
  s.time_ns = time_ns;
  s.position = position;
  s.velocity = velocity;
  if (sigma_m > 0.0) s.covariance = sigma_m * sigma_m * Mat2::Identity();
  return s;
}

survey::ReceivedPacket seen(std::int64_t capture_ns, std::int64_t arrival_ns, const std::vector<Vec2>& positions,
                            double sigma_m = 0.5) {
  survey::ReceivedPacket r;
  r.arrival_time_ns = arrival_ns;
  r.packet.capture_time_ns = capture_ns;
  for (const auto& p : positions)
    r.packet.vehicles.push_back({{p.x(), p.y(), 0.0}, sigma_m * sigma_m * Mat2::Identity()});
  return r;
}

PoseFilterOptions paper() {
  PoseFilterOptions o;
  o.mode = "paper";
  return o;
}

// Paper B's filter with all its seven states, (B.5) to (B.8), written out.
class SevenStates {
 public:
  SevenStates(const VehicleState& first, const PoseFilterOptions& o) : options_(o), before_(first) {
    x_.setZero();
    x_.head<2>() = first.position;
    x_.segment<2>(2) = first.velocity;
    p_.setZero();
    p_.topLeftCorner<2, 2>() = *first.covariance;
    p_.block<2, 2>(2, 2) = std::pow(o.paper_sigma_velocity_m_s, 2) * Mat2::Identity();
  }
  void predict(const VehicleState& now) {
    const double dt = 0.02;
    Eigen::Matrix<double, 7, 7> f = Eigen::Matrix<double, 7, 7>::Zero(), q = f;
    f.block<2, 2>(0, 0).setIdentity();
    f.block<2, 2>(0, 2) = 0.5 * dt * Mat2::Identity();
    q.block<2, 2>(0, 0) = std::pow(options_.paper_sigma_position_m, 2) * Mat2::Identity();
    q.block<2, 2>(2, 2) = std::pow(options_.paper_sigma_velocity_m_s, 2) * Mat2::Identity();
    const Vec2 velocity = x_.segment<2>(2) + before_.velocity;
    x_.head<2>() += 0.5 * dt * velocity;
    x_.segment<2>(2) = now.velocity;
    p_ = (f * p_ * f.transpose()).eval() + q;
    before_ = now;
  }
  void update(const Vec2& z) {
    Eigen::Matrix<double, 2, 7> h = Eigen::Matrix<double, 2, 7>::Zero();
    h.leftCols<2>().setIdentity();
    const Mat2 r = std::pow(options_.projector_sigma_m, 2) * Mat2::Identity();
    const Eigen::Matrix<double, 7, 2> k = p_ * h.transpose() * (h * p_ * h.transpose() + r).inverse();
    x_ += k * (z - h * x_);
    p_ = ((Eigen::Matrix<double, 7, 7>::Identity() - k * h) * p_).eval();
  }
  [[nodiscard]] Vec2 position() const { return x_.head<2>(); }
  [[nodiscard]] Mat2 covariance() const { return p_.topLeftCorner<2, 2>(); }

 private:
  PoseFilterOptions options_;
  VehicleState before_;
  Eigen::Matrix<double, 7, 1> x_;
  Eigen::Matrix<double, 7, 7> p_;
};

TEST(PaperFilter, IsThePapersSevenStateFilter) {
  const auto options = paper();
  PoseFilter filter(options);
  base::Random random(1, "pose_filter_test", 0);
  const auto at = [](int k) {
    const double t = 0.02 * k;
    return sample(k * kStep_ns, {t, 0.1 * t * t}, {1.0, 0.2 * t}, 1.5);
  };
  SevenStates oracle(at(0), options);
  filter.inertial(at(0));
  for (int k = 1; k < 2000; ++k) {
    const auto s = at(k);
    const bool update = k % 17 == 0;
    const Vec2 z = s.position + 0.3 * Vec2(random.normal(), random.normal());
    if (update) filter.packet(seen(s.time_ns - 300'000'000, s.time_ns, {z}));
    filter.inertial(s);
    oracle.predict(s);
    if (update) oracle.update(z);
    ASSERT_LT((filter.state().position - oracle.position()).norm(), kRounding_m) << k;
    ASSERT_LT((*filter.state().covariance - oracle.covariance()).norm(), kRounding_m) << k;
  }
  for (const auto& u : filter.updates()) EXPECT_TRUE(u.accepted);
}

TEST(PaperFilter, TwoStepsAgainstFalseVehicles) {
  PoseFilter filter(paper());
  // Stands at (0, 0); its log believes to be at (1, 0).
  filter.inertial(sample(0, {1, 0}, {0, 0}, 0.5));
  for (int k = 1; k <= 50; ++k) filter.inertial(sample(k * kStep_ns, {1, 0}, {0, 0}));
  filter.packet(seen(900'000'000, 1'000'000'000, {{0.2, 0}}));
  filter.inertial(sample(51 * kStep_ns, {1, 0}, {0, 0}));
  for (int k = 52; k <= 76; ++k) filter.inertial(sample(k * kStep_ns, {1, 0}, {0, 0}));
  filter.packet(seen(1'400'000'000, 1'520'000'000, {{5, 0}, {-0.4, 0}, {0.4, 0}}));
  filter.inertial(sample(77 * kStep_ns, {1, 0}, {0, 0}));
  ASSERT_EQ(filter.updates().size(), 4U);
  EXPECT_TRUE(filter.updates()[0].accepted);
  EXPECT_EQ(filter.updates()[1].reason, "impossible_move");  // 4.7 m in 0.5 s, at most 3 m/s and 1.5 m
  EXPECT_EQ(filter.updates()[2].reason, "not_nearest");      // 1.4 m from the log, the other 0.6 m
  EXPECT_TRUE(filter.updates()[3].accepted);
}

TEST(RobustFilter, ALatePacketCountsAtItsCapture) {
  // Drives east at 1 m/s; seen exactly, 2 s late. Applied on arrival it would pull the vehicle 2 m back.
  const auto run = [](const std::string& mode) {
    PoseFilterOptions o;
    o.mode = mode;
    PoseFilter filter(o);
    for (int k = 0; k <= 500; ++k) {
      const double t = 0.02 * k;
      filter.inertial(sample(k * kStep_ns, {t, 0}, {1, 0}, k == 0 ? 0.5 : 0.0));
      if (k % 25 == 0 && k > 100) filter.packet(seen((k - 100) * kStep_ns, k * kStep_ns, {{t - 2.0, 0}}));
    }
    return filter.state().position.x() - 10.0;
  };
  constexpr double kExact_m = 1e-6;
  EXPECT_NEAR(run("robust"), 0.0, kExact_m);
  EXPECT_LT(run("paper"), -0.5);
}

TEST(RobustFilter, TheOrderOfArrivalDoesNotMatter) {
  cairn::testing::DriveOptions options;
  options.duration_s = 60.0;
  const auto drive = cairn::testing::make_drive(options, 4);
  const auto run = [&](bool turned) {
    PoseFilterOptions o;
    o.buffer_s = 100.0;
    PoseFilter filter(o);
    auto packets = drive.packets;
    if (turned) std::reverse(packets.begin(), packets.end());
    for (const auto& s : drive.log) filter.inertial(s);
    for (const auto& p : packets) filter.packet(p);
    return filter.state();
  };
  const auto forward = run(false), backward = run(true);
  EXPECT_LT((forward.position - backward.position).norm(), kRounding_m);
  EXPECT_LT((*forward.covariance - *backward.covariance).norm(), kRounding_m);

  // And it is the estimate of a filter that got everything in time.
  PoseFilter online{PoseFilterOptions{}};
  std::vector<survey::ReceivedPacket> in_time = drive.packets;
  for (auto& p : in_time) p.arrival_time_ns = p.packet.capture_time_ns;
  std::size_t next = 0;
  for (const auto& s : drive.log) {
    while (next < in_time.size() && in_time[next].arrival_time_ns < s.time_ns) online.packet(in_time[next++]);
    online.inertial(s);
  }
  EXPECT_LT((forward.position - online.state().position).norm(), kRounding_m);
}

TEST(RobustFilter, TheBiasOfTheLogIsFound) {
  PoseFilter filter{PoseFilterOptions{}};
  base::Random random(3, "pose_filter_test", 1);
  const Vec2 bias(0.03, -0.02);
  for (int k = 0; k <= 30000; ++k) {
    filter.inertial(sample(k * kStep_ns, {0, 0}, bias, k == 0 ? 0.5 : 0.0));
    if (k % 12 == 11) filter.packet(seen(k * kStep_ns, k * kStep_ns, {0.5 * Vec2(random.normal(), random.normal())}));
  }
  // Its own sigma is 0.013 m/s: a drifting bias is known no better than of the last half minute.
  constexpr double kBias_m_s = 0.03;
  EXPECT_LT((filter.estimate().mean.segment<2>(2) - bias).norm(), kBias_m_s);
  EXPECT_LT(filter.state().velocity.norm(), kBias_m_s);
  EXPECT_LT(std::sqrt(filter.estimate().covariance(2, 2)), 0.02);
}

TEST(RobustFilter, FalseVehiclesHaveReasonsAndNoEffect) {
  PoseFilter filter{PoseFilterOptions{}};
  int k = 0;
  const auto drive = [&](int steps) {
    for (int i = 0; i < steps; ++i, ++k) filter.inertial(sample(k * kStep_ns, {0, 0}, {0, 0}, k == 0 ? 0.5 : 0.0));
  };
  const auto now = [&] { return (k - 1) * kStep_ns; };
  drive(10);
  for (int i = 0; i < 20; ++i) {
    filter.packet(seen(now(), now(), {{0, 0}}));
    drive(12);
  }
  const auto before = filter.state();
  filter.packet(seen(now(), now(), {{9, 0}}));
  filter.packet(seen(now(), now(), {{0, 2.6}}));
  EXPECT_EQ(filter.state().position, before.position);
  const auto& updates = filter.updates();
  EXPECT_EQ(updates[20].reason, "impossible_move");
  EXPECT_EQ(updates[21].reason, "outside_gate");
  EXPECT_GT(updates[21].gate, 4.0);
  filter.packet(seen(now(), now(), {{1.2, 0}, {0.1, 0}}));
  EXPECT_EQ(filter.updates()[22].reason, "not_nearest");
  EXPECT_TRUE(filter.updates()[23].accepted);
}

TEST(RobustFilter, ReturnsFromAWrongBelief) {
  // The log starts 40 m beside the truth and claims half a metre. The vehicle goes north at 1 m/s.
  PoseFilter filter{PoseFilterOptions{}};
  for (int k = 0; k <= 1000; ++k) {
    const double north = 0.02 * k;
    filter.inertial(sample(k * kStep_ns, {40, north}, {0, 1}, k == 0 ? 0.5 : 0.0));
    if (k % 25 == 24) filter.packet(seen(k * kStep_ns, k * kStep_ns, {{0.1 * (k % 3), north}}));
  }
  constexpr double kNear_m = 0.5;
  EXPECT_LT((filter.state().position - Vec2(0, 20)).norm(), kNear_m);
  std::size_t recovered = 0;
  for (const auto& u : filter.updates()) recovered += u.reason == "recovered" ? 1U : 0U;
  EXPECT_EQ(recovered, 1U);
}

TEST(RobustFilter, AFixedFalseVehicleIsNeverBelieved) {
  // Something 12 m away is taken for the vehicle in every image; the vehicle stands, then drives past it, then stands.
  PoseFilter filter{PoseFilterOptions{}};
  double north = 0.0;
  for (int k = 0; k <= 3000; ++k) {
    const bool drives = k > 1000 && k <= 2000;
    if (drives) north += 0.02;
    filter.inertial(sample(k * kStep_ns, {0, north}, {0, drives ? 1.0 : 0.0}, k == 0 ? 0.5 : 0.0));
    if (k % 10 == 9) filter.packet(seen(k * kStep_ns, k * kStep_ns, {{12, 6}}));
  }
  for (const auto& u : filter.updates()) EXPECT_FALSE(u.accepted);
}

TEST(RobustFilter, StrayPositionsNeverRecover) {
  // One vehicle that is seen nowhere near, every time elsewhere.
  PoseFilter filter{PoseFilterOptions{}};
  base::Random random(5, "pose_filter_test", 2);
  for (int k = 0; k <= 5000; ++k) {
    filter.inertial(sample(k * kStep_ns, {0, 0}, {0, 0}, k == 0 ? 0.1 : 0.0));
    if (k % 25 == 24) {
      const double angle = random.uniform(0, 2 * std::numbers::pi);
      filter.packet(
          seen(k * kStep_ns, k * kStep_ns, {random.uniform(20, 40) * Vec2(std::cos(angle), std::sin(angle))}));
    }
  }
  for (const auto& u : filter.updates()) EXPECT_FALSE(u.accepted);
  EXPECT_EQ(filter.state().position, Vec2(0, 0));
}

TEST(RobustFilter, BadPacketsHaveReasons) {
  PoseFilterOptions o;
  o.buffer_s = 2.0;
  PoseFilter filter(o);
  filter.packet(seen(0, 0, {{0, 0}}));
  for (int k = 0; k <= 500; ++k) filter.inertial(sample(k * kStep_ns, {0, 0}, {0, 0}, k == 0 ? 0.5 : 0.0));
  const std::int64_t now = 500 * kStep_ns;
  filter.packet(seen(now - 3'000'000'000, now, {{0, 0}}));
  filter.packet(seen(now + 1, now, {{0, 0}}));
  auto nan = seen(now, now, {{0, 0}, {0.1, 0}});
  nan.packet.vehicles[0].covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  filter.packet(nan);
  const auto& u = filter.updates();
  ASSERT_EQ(u.size(), 5U);
  EXPECT_EQ(u[0].reason, "before_log");
  EXPECT_EQ(u[1].reason, "too_late");
  EXPECT_EQ(u[2].reason, "arrived_before_capture");
  EXPECT_EQ(u[3].reason, "not_finite");
  EXPECT_TRUE(u[4].accepted);
  EXPECT_TRUE(filter.state().position.allFinite());
}

TEST(RobustFilter, SamplesThatCannotBeUsedAreRefused) {
  PoseFilter filter{PoseFilterOptions{}};
  EXPECT_THROW(static_cast<void>(filter.state()), base::Error);
  EXPECT_TRUE(filter.inertial(sample(100, {0, 0}, {1, 0})));
  EXPECT_FALSE(filter.inertial(sample(100, {0, 0}, {1, 0})));
  EXPECT_FALSE(filter.inertial(sample(50, {0, 0}, {1, 0})));
  EXPECT_FALSE(filter.inertial(sample(200, {0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0})));
  EXPECT_TRUE(filter.inertial(sample(200, {0, 0}, {1, 0})));
}

TEST(RobustFilter, GapsWidenTheCovariance) {
  const auto sigma_after = [](std::int64_t gap_ns) {
    PoseFilter filter{PoseFilterOptions{}};
    filter.inertial(sample(0, {0, 0}, {1, 0}, 0.1));
    filter.inertial(sample(kStep_ns, {0, 0}, {1, 0}));
    filter.inertial(sample(kStep_ns + gap_ns, {0, 0}, {1, 0}));
    EXPECT_NEAR(filter.state().position.x(), 1e-9 * static_cast<double>(kStep_ns + gap_ns), kRounding_m);
    return std::sqrt((*filter.state().covariance)(0, 0));
  };
  EXPECT_LT(sigma_after(100'000'000), 0.11);
  EXPECT_GT(sigma_after(3'000'000'000), 1.4);  // 3 s at 0.5 m/s
}

TEST(RobustFilter, StatesBetweenAndBehindSamples) {
  PoseFilter filter{PoseFilterOptions{}};
  for (int k = 0; k <= 100; ++k) filter.inertial(sample(k * kStep_ns, {0, 0}, {2, 0}, k == 0 ? 0.5 : 0.0));
  for (const double t : {0.5, 0.507, 1.999, 2.0, 2.1}) {
    const auto s = filter.at(static_cast<std::int64_t>(std::llround(t * 1e9)));
    EXPECT_NEAR(s.position.x(), 2.0 * t, kRounding_m) << t;
    EXPECT_EQ(s.time_ns, static_cast<std::int64_t>(std::llround(t * 1e9)));
  }
}

TEST(RobustFilter, OptionsOutOfRangeAreRefused) {
  PoseFilterOptions o;
  o.mode = "smooth";
  EXPECT_THROW(PoseFilter{o}, base::Error);
  o = {};
  o.projector_sigma_m = -1.0;
  EXPECT_THROW(PoseFilter{o}, base::Error);
}

}  // namespace
