#include "fragility/pulse_criteria.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "fragility/tipping.hpp"

namespace cairn::fragility {
namespace {

// The rectangle 1.0 x 3.0 m of the reference table; half the last printed digit.
constexpr double kAlpha = 0.32175055439664219, kP = 2.1567805888;
constexpr double kFiveDigits = 5.1e-6;

TEST(PulseCriteria, VelocityStepOfTheRectangle) {
  EXPECT_NEAR(velocity_step(kAlpha, kP), 1.535458, 5.1e-7);
  EXPECT_NEAR(velocity_step(kAlpha, kP, true), 1.462965, 5.1e-7);
  // V^2 = (8 g R / 3) (1 - cos alpha) / cos^2 alpha.
  const double r = std::hypot(0.5, 1.5), c = std::cos(kAlpha);
  EXPECT_NEAR(velocity_step(kAlpha, std::sqrt(0.75 * kGravity / r)),
              std::sqrt(8.0 * kGravity * r / 3.0 * (1.0 - c)) / c, 1e-12);
}

TEST(PulseCriteria, RectangularPulse) {
  EXPECT_NEAR(rectangular_pulse_ratio(kP, 0.10), 5.15450, kFiveDigits);
  EXPECT_NEAR(rectangular_pulse_ratio(kP, 0.30), 2.09906, kFiveDigits);
  EXPECT_NEAR(rectangular_pulse_ratio(kP, 0.60), 1.37770, kFiveDigits);
  EXPECT_NEAR(rectangular_pulse_ratio(kP, 1.00), 1.13083, kFiveDigits);
  for (const double t : {0.1, 0.3, 0.6, 1.0}) {
    const double x = rectangular_pulse_ratio(kP, t);
    EXPECT_NEAR(std::cosh(kP * t), 1.0 + 1.0 / (2.0 * x * (x - 1.0)), 1e-9);  // Housner's form
  }
}

TEST(PulseCriteria, HalfSine) {
  EXPECT_NEAR(half_sine_ratio(1.0), 1.32240, kFiveDigits);
  EXPECT_NEAR(half_sine_ratio(2.0), 1.80072, kFiveDigits);
  EXPECT_NEAR(half_sine_ratio(4.0), 2.79080, kFiveDigits);
  EXPECT_NEAR(half_sine_ratio(8.0), 4.78707, kFiveDigits);
  const double housner[] = {1.41421, 2.23607, 4.12311, 8.06226};
  const double over[] = {1.07, 1.24, 1.48, 1.68};
  for (int i = 0; i < 4; ++i) {
    const double q = std::pow(2.0, i);
    EXPECT_NEAR(half_sine_ratio_housner(q), housner[i], kFiveDigits);
    EXPECT_NEAR(half_sine_ratio_housner(q) / half_sine_ratio(q), over[i], 0.0051);
  }
  EXPECT_NEAR(half_sine_ratio(0.01), 1.0, 1e-3);  // a long pulse: the static limit
}

TEST(PulseCriteria, FreeRocking) {
  EXPECT_NEAR(quarter_period_times_p(0.2), 0.69315, kFiveDigits);
  EXPECT_NEAR(quarter_period_times_p(0.5), 1.31696, kFiveDigits);
  EXPECT_NEAR(quarter_period_times_p(0.8), 2.29243, kFiveDigits);
}

TEST(PulseCriteria, RectangleKeepsEightyFivePercent) {
  EXPECT_NEAR(rectangle_restitution(kAlpha), 0.85, 1e-12);
}

TEST(PulseCriteria, WrongArgumentsAreRefused) {
  EXPECT_THROW((void)velocity_step(1.6, 2.0), base::Error);
  EXPECT_THROW((void)rectangular_pulse_ratio(2.0, 0.0), base::Error);
  EXPECT_THROW((void)half_sine_ratio(0.0), base::Error);
  EXPECT_THROW((void)quarter_period_times_p(1.0), base::Error);
}

}  // namespace
}  // namespace cairn::fragility
