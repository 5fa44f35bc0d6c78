#include "dynamics/base_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.hpp"

namespace cairn::dynamics {
namespace {

using geometry::Vec3;

TEST(OneCosine, HasThePeakValuesAndTheDirectionAsked) {
  constexpr double kPga = 3.0, kRatio = 0.2;  // m/s^2, s
  const auto motion = one_cosine(kPga, kRatio, 90.0);
  EXPECT_NEAR(motion.duration(), 2.0 * std::numbers::pi * kRatio, 1e-12);
  double pgv = 0.0, pga = 0.0;
  for (std::size_t i = 0; i < motion.velocity_m_s.size(); ++i) {
    const Vec3& v = motion.velocity_m_s[i];
    EXPECT_NEAR(v.y(), 0.0, 1e-15);
    EXPECT_EQ(v.z(), 0.0);
    pgv = std::max(pgv, std::abs(v.x()));
    if (i > 0) pga = std::max(pga, std::abs(v.x() - motion.velocity_m_s[i - 1].x()) / motion.step_s);
  }
  EXPECT_NEAR(pgv, kPga * kRatio, 1e-6);
  EXPECT_NEAR(pga, kPga, 1e-5);  // chord of the cosine over 1/2000 of the period
  EXPECT_GT(motion.velocity(0.01).x(), 0.0);
  EXPECT_EQ(motion.velocity_m_s.back(), Vec3(0, 0, 0));
}

TEST(BaseMotionVelocity, IsLinearBetweenSamplesAndHeldOutside) {
  const BaseMotion motion{0.5, {Vec3(0, 0, 0), Vec3(1, 2, 3)}};
  EXPECT_EQ(motion.velocity(-0.1), Vec3(0, 0, 0));
  EXPECT_TRUE(motion.velocity(0.25).isApprox(Vec3(0.5, 1, 1.5)));
  EXPECT_EQ(motion.velocity(7.0), Vec3(1, 2, 3));
  EXPECT_EQ(BaseMotion{}.velocity(1.0), Vec3(0, 0, 0));
}

TEST(FromAcceleration, IntegratesByTrapezoids) {
  const std::vector<Vec3> a = {Vec3(0, 0, 0), Vec3(2, 0, -1), Vec3(2, 0, -1)};
  const auto motion = from_acceleration(0.1, a);
  EXPECT_TRUE(motion.velocity_m_s[1].isApprox(Vec3(0.1, 0, -0.05)));
  EXPECT_TRUE(motion.velocity_m_s[2].isApprox(Vec3(0.3, 0, -0.15)));
  EXPECT_TRUE(scaled(motion, 2.0).velocity_m_s[2].isApprox(Vec3(0.6, 0, -0.3)));
}

TEST(BaseMotionInput, RefusesWhatIsNotAMotion) {
  EXPECT_THROW((void)one_cosine(1.0, 0.0, 0.0), base::Error);
  EXPECT_THROW((void)one_cosine(-1.0, 0.1, 0.0), base::Error);
  const std::vector<Vec3> bad = {Vec3(0, 0, 0), Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0)};
  EXPECT_THROW((void)from_acceleration(0.1, bad), base::Error);
  EXPECT_THROW((void)from_acceleration(0.0, std::span(bad).first(1)), base::Error);
}

}  // namespace
}  // namespace cairn::dynamics
