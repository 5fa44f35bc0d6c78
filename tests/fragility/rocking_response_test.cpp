#include "fragility/rocking_response.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/random.hpp"
#include "fragility/ground_motion.hpp"
#include "fragility/pulse_criteria.hpp"

namespace cairn::fragility {
namespace {

// The rectangle 1.0 x 3.0 m of the reference table.
const RockingProfile kBlock = rectangle_profile(0.5, 1.5);
const double kAlpha = std::atan(1.0 / 3.0);
const double kP = std::sqrt(0.75 * kGravity / std::hypot(0.5, 1.5));

// A slender body with the same p: its equation of motion is the linear one.
RockingProfile slender(double alpha = 1e-5) {
  RockingProfile profile = kBlock;
  profile.toes[0].alpha = -alpha;
  profile.toes[1].alpha = alpha;
  return profile;
}

RockingResult rock_pulse(const RockingProfile& profile, const Pulse& pulse, double scale = 1.0,
                         const RockingOptions& options = {}) {
  return rock(profile, {pulse.acceleration, {}, pulse.dt, scale, 0.0, 0.0}, options);
}

// Least scale that overturns; for pulses of one sign only, where overturning is monotone.
double threshold(const RockingProfile& profile, const Pulse& pulse, double lo, double hi) {
  for (int i = 0; i < 40; ++i) {
    const double mid = 0.5 * (lo + hi);
    (rock_pulse(profile, pulse, mid).overturned ? hi : lo) = mid;
  }
  return hi;
}

TEST(RockingResponse, ImpactOfTheRectangleKeepsHousnersShare) {
  EXPECT_NEAR(kBlock.toes[0].eta_from_up, 0.85, 1e-12);
  EXPECT_NEAR(kBlock.toes[1].eta_from_down, rectangle_restitution(kAlpha), 1e-12);
  EXPECT_NEAR(std::sqrt(kBlock.toes[1].p_squared), 2.156781, 5.1e-7);
}

TEST(RockingResponse, RestsBelowItsTippingAccelerationAndRocksAbove) {
  const Pulse below = rectangular_pulse(0.999999 * kGravity / 3.0, 1.0);
  const Pulse above = rectangular_pulse(1.000001 * kGravity / 3.0, 1.0);
  EXPECT_FALSE(rock_pulse(kBlock, below).rocked);
  EXPECT_TRUE(rock_pulse(kBlock, above).rocked);
}

TEST(RockingResponse, StartsExactlyAtTheTippingAcceleration) {
  // A ramp of 1 g in 1 s with a coarse step: a_qs = 1/3 g is reached at 1/3 s.
  const std::vector<double> ramp = {0.0, kGravity};
  const auto result = rock(kBlock, {ramp, {}, 1.0, 1.0, 0.0, 0.0});
  EXPECT_NEAR(result.first_uplift_s, 1.0 / 3.0, 1e-15);
}

// Ground to +u makes the rock topple against u.
TEST(RockingResponse, TopplesAgainstTheMotionOfTheGround) {
  const Pulse push = rectangular_pulse(kGravity, 1.0);
  const auto result = rock_pulse(kBlock, push);
  EXPECT_TRUE(result.overturned);
  EXPECT_EQ(result.side, -1);
  EXPECT_EQ(rock_pulse(kBlock, push, -1.0).side, 1);
}

TEST(RockingResponse, VelocityStepThreshold) {
  // After a step of the ground's velocity V the body turns about its toe with p^2 V cos(alpha) / g.
  const std::vector<double> still = {0.0, 0.0};
  const double v = velocity_step(kAlpha, kP);
  const auto after = [&](double factor) {
    const double rate = factor * v * kP * kP * std::cos(kAlpha) / kGravity;
    return rock(kBlock, {still, {}, 0.01, 1.0, 0.0, rate});
  };
  EXPECT_FALSE(after(1.0 - 1e-9).overturned);
  EXPECT_TRUE(after(1.0 + 1e-9).overturned);
  EXPECT_NEAR(after(1.0 - 1e-9).peak_up, 1.0, 1e-4);
}

// The table of the pulses, linear equation: the closed forms to all their digits.
TEST(RockingResponse, LinearEquationMeetsTheClosedForms) {
  constexpr double kDigits = 1.5e-5;  // relative; half a digit of the table and the slender body's own alpha
  const double alpha = 1e-5;
  for (const double t : {0.1, 0.3, 0.6, 1.0}) {
    const double expected = rectangular_pulse_ratio(kP, t);
    const double found =
        threshold(slender(alpha), rectangular_pulse(1.0, t), 0.5 * kGravity * alpha, 10 * kGravity * alpha);
    EXPECT_NEAR(found / (kGravity * alpha), expected, kDigits * expected) << t;
  }
  for (const double q : {1.0, 2.0, 4.0, 8.0}) {
    const double expected = half_sine_ratio(q);
    const double found =
        threshold(slender(alpha), half_sine(1.0, q * kP, 1000), 0.5 * kGravity * alpha, 10 * kGravity * alpha);
    EXPECT_NEAR(found / (kGravity * alpha), expected, kDigits * expected) << q;
  }
}

// The column "nonlinear" of the reference table. Its rectangular pulses came from steps that the table's own linear
// column shows to be off by 3e-4 (0.1 s); its half sines agree with the closed form to all digits.
TEST(RockingResponse, NonlinearColumnOfTheTable) {
  constexpr double kRectangular = 5e-4, kHalfSine = 5e-6;  // relative
  const double unit = kGravity / 3.0;                      // g tan(alpha)
  const double durations[] = {0.1, 0.3, 0.6, 1.0}, expected[] = {5.20021, 2.10512, 1.37671, 1.12876};
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(threshold(kBlock, rectangular_pulse(unit, durations[i]), 0.5, 10.0), expected[i],
                kRectangular * expected[i]);
  const double qs[] = {1.0, 2.0, 4.0, 8.0}, sine[] = {1.32045, 1.80187, 2.80185, 4.82183};
  for (int i = 0; i < 4; ++i)
    EXPECT_NEAR(threshold(kBlock, half_sine(unit, qs[i] * kP, 4000), 0.5, 10.0), sine[i], kHalfSine * sine[i] + 5e-6);
}

// Free rocking from theta_0: a quarter period later the body stands upright.
TEST(RockingResponse, QuarterPeriodOfFreeRocking) {
  const std::vector<double> still(3001, 0.0);
  const double alpha = 1e-5, expected[] = {0.69315, 1.31696, 2.29243};
  int i = 0;
  for (const double r : {0.2, 0.5, 0.8}) {
    std::vector<RockingSample> history;
    (void)rock(slender(alpha), {still, {}, 0.0005, 1.0, r * alpha, 0.0}, {}, &history);
    double upright = 0.0;
    for (const auto& s : history)
      if (s.theta <= 0.0) {
        upright = s.time_s;
        break;
      }
    EXPECT_NEAR(kP * upright, expected[i++], 1e-5) << r;
  }
}

// Each impact of free rocking keeps eta^2 of the energy, and the body comes to rest.
TEST(RockingResponse, FreeRockingDecaysByTheImpacts) {
  const std::vector<double> still(20001, 0.0);
  std::vector<RockingSample> history;
  const auto result = rock(kBlock, {still, {}, 0.001, 1.0, 0.5 * kAlpha, 0.0}, {}, &history);
  EXPECT_FALSE(result.overturned);
  // theta_1 after the first impact: 1 - cos(alpha - theta_1) measured from the peak's height.
  const double e0 = std::cos(kAlpha - 0.5 * kAlpha) - std::cos(kAlpha);
  const double e1 = 0.85 * 0.85 * e0;
  const double expected = kAlpha - std::acos(std::cos(kAlpha) + e1);
  double lowest = 0.0;
  for (const auto& s : history) lowest = std::min(lowest, s.theta);
  EXPECT_NEAR(-lowest, expected, 1e-6);
  EXPECT_NEAR(result.peak_down * kAlpha, expected, 1e-9);
  EXPECT_EQ(history.back().theta, 0.0);
  EXPECT_EQ(history.back().rate, 0.0);
  // Amplitudes fall by eta^2 = 0.7225 until the rest at 1e-6: ln(1e-6) / ln(0.7225) = 42.5 impacts.
  EXPECT_NEAR(static_cast<double>(result.impacts), 42.0, 3.0);
}

// The energy rule after the record gives the outcome that integration gives.
TEST(RockingResponse, OutcomeAfterTheRecordIsThatOfIntegration) {
  const std::vector<double> still(60001, 0.0);
  int overturned = 0;
  for (std::uint64_t k = 0; k < 200; ++k) {
    base::Random random(7, "after the record", k);
    const auto profile = two_toe_profile(random.uniform(0.1, 0.6), random.uniform(0.6, 1.5), random.uniform(0.1, 0.6),
                                         random.uniform(0.6, 1.5), 0.5);
    const Pulse pulse = one_cosine(random.uniform(0.5, 12.0), random.uniform(0.05, 0.4));
    std::vector<RockingSample> states;
    const auto closed = rock(profile, {pulse.acceleration, {}, pulse.dt, 1.0, 0.0, 0.0}, {}, &states);
    const auto last = states.back();
    overturned += closed.overturned ? 1 : 0;
    if (last.theta == 0.0 && last.rate == 0.0) continue;
    const auto integrated = rock(profile, {still, {}, 0.001, 1.0, last.theta, last.rate});
    EXPECT_EQ(integrated.overturned, closed.overturned) << k;
    EXPECT_EQ(integrated.side, closed.side) << k;
    EXPECT_LE(integrated.peak_up, closed.peak_up + 1e-6) << k;
  }
  EXPECT_GT(overturned, 40);
  EXPECT_LT(overturned, 160);
}

// Steps of the record against steps of 1e-3 / p and a tighter tolerance: the same outcomes and peaks.
TEST(RockingResponse, StepsOfTheRecordAreFineEnough) {
  int rocked = 0;
  for (std::uint64_t k = 0; k < 30; ++k) {
    base::Random random(11, "steps", k);
    std::vector<double> record(2000);
    double a = 0.0;
    for (auto& x : record) x = a = 0.95 * a + random.normal();
    const double scale = random.uniform(0.2, 0.8);
    const auto coarse = rock(kBlock, {record, {}, 0.01, scale, 0.0, 0.0});
    RockingOptions fine;
    fine.max_step_s = 1e-3 / kP;
    fine.tolerance = 1e-11;
    const auto exact = rock(kBlock, {record, {}, 0.01, scale, 0.0, 0.0}, fine);
    EXPECT_EQ(coarse.overturned, exact.overturned) << k;
    // Past alpha the fall ends at whichever step passes the stop.
    EXPECT_NEAR(std::min(coarse.peak_up, 1.0), std::min(exact.peak_up, 1.0), 1e-6) << k;
    rocked += coarse.rocked && !coarse.overturned ? 1 : 0;
  }
  EXPECT_GT(rocked, 5);
}

TEST(RockingResponse, MirrorImageGivesTheMirrorResponse) {
  const auto one = two_toe_profile(0.3, 1.0, 0.5, 1.1, 0.4), other = two_toe_profile(0.5, 1.1, 0.3, 1.0, 0.4);
  base::Random random(3, "mirror", 0);
  std::vector<double> record(1500);
  for (auto& x : record) x = 4.0 * random.normal();
  const auto a = rock(one, {record, {}, 0.02, 1.0, 0.0, 0.0}), b = rock(other, {record, {}, 0.02, -1.0, 0.0, 0.0});
  EXPECT_EQ(a.overturned, b.overturned);
  EXPECT_EQ(a.side, -b.side);
  EXPECT_NEAR(a.peak_up, b.peak_down, 1e-9);
  EXPECT_EQ(a.impacts, b.impacts);
}

// Size: a body 4 times as large under a motion 2 times as slow responds alike (p ~ s^-1/2).
TEST(RockingResponse, ScalesWithSize) {
  base::Random random(5, "size", 0);
  std::vector<double> record(1000);
  for (auto& x : record) x = 3.0 * random.normal();
  const auto small = rock(rectangle_profile(0.2, 0.6), {record, {}, 0.01, 1.0, 0.0, 0.0});
  const auto large = rock(rectangle_profile(0.8, 2.4), {record, {}, 0.02, 1.0, 0.0, 0.0});
  EXPECT_EQ(small.overturned, large.overturned);
  EXPECT_EQ(small.impacts, large.impacts);
  EXPECT_NEAR(small.peak_up, large.peak_up, 1e-9);
}

// Upward acceleration holds the rock down: the tipping acceleration is (g + a_v) d / H.
TEST(RockingResponse, VerticalAccelerationCounts) {
  const std::vector<double> ramp = {0.0, kGravity}, up = {0.5 * kGravity, 0.5 * kGravity};
  const auto result = rock(kBlock, {ramp, up, 1.0, 1.0, 0.0, 0.0});
  EXPECT_NEAR(result.first_uplift_s, 0.5, 1e-14);
  EXPECT_FALSE(result.lifted_off);
  const std::vector<double> down = {-2.0 * kGravity, -2.0 * kGravity};
  EXPECT_TRUE(rock(kBlock, {ramp, down, 1.0, 1.0, 0.0, 0.0}).lifted_off);
}

// The rock may pass alpha and come back: the ground reverses in time.
TEST(RockingResponse, PassingAlphaIsNotOverturning) {
  bool passed_and_returned = false;
  for (std::size_t reverse = 5; reverse < 80 && !passed_and_returned; ++reverse) {
    std::vector<double> r(800, 0.0);
    for (std::size_t i = 0; i < 60; ++i) r[i] = -0.6 * kGravity;
    for (std::size_t i = 60; i < 60 + reverse; ++i) r[i] = 0.9 * kGravity;
    const auto result = rock(kBlock, {r, {}, 0.01, 1.0, 0.0, 0.0});
    passed_and_returned = result.peak_up > 1.0 && !result.overturned;
  }
  EXPECT_TRUE(passed_and_returned);
}

TEST(RockingResponse, RestitutionIsSharedByEnergy) {
  const auto lifted = with_restitution(kBlock, 0.5);
  EXPECT_NEAR(lifted.toes[0].eta_from_up, std::sqrt(0.5 * (1.0 + 0.85 * 0.85)), 1e-12);
  const auto fixed = with_fixed_restitution(two_toe_profile(0.3, 1.0, 0.5, 1.1, 0.4), 0.9);
  EXPECT_NEAR(fixed.toes[0].eta_from_up * fixed.toes[1].eta_from_down, 0.81, 1e-12);
}

TEST(RockingResponse, WrongInputIsRefused) {
  const std::vector<double> one = {1.0}, two = {1.0, 1.0}, three = {1.0, 1.0, 1.0};
  EXPECT_THROW((void)rock(kBlock, {one, {}, 0.01, 1.0, 0.0, 0.0}), base::Error);
  EXPECT_THROW((void)rock(kBlock, {two, {}, 0.0, 1.0, 0.0, 0.0}), base::Error);
  EXPECT_THROW((void)rock(kBlock, {two, three, 0.01, 1.0, 0.0, 0.0}), base::Error);
  RockingProfile unstable = kBlock;
  unstable.toes[1].alpha = -0.1;
  EXPECT_THROW((void)rock(unstable, {two, {}, 0.01, 1.0, 0.0, 0.0}), base::Error);
}

}  // namespace
}  // namespace cairn::fragility
