#include "adjustment/patch_correlation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "adjustment/robust.hpp"

namespace cairn::adjustment {
namespace {

double pattern(double x, double y) {
  return 100.0 + 30.0 * std::sin(0.9 * x + 0.3 * y) + 20.0 * std::cos(0.5 * y - 0.2 * x) +
         10.0 * std::sin(0.13 * x * y);
}

Window window_of(std::size_t side, double offset_x, double offset_y) {
  Window window{side, {}};
  for (std::size_t r = 0; r < side; ++r)
    for (std::size_t c = 0; c < side; ++c)
      window.values.push_back(
          static_cast<float>(pattern(static_cast<double>(c) - 0.5 * static_cast<double>(side) - offset_x,
                                     static_cast<double>(r) - 0.5 * static_cast<double>(side) - offset_y)));
  return window;
}

TEST(PatchCorrelation, FindsTheShiftToATenthOfACell) {
  constexpr double kCells = 0.1;  // a quadric through nine scores of a smooth pattern
  for (const double dx : {-3.0, 0.0, 1.4})
    for (const double dy : {-2.3, 0.0, 2.0}) {
      const auto peak = correlate(window_of(21, dx, dy), window_of(33, 0.0, 0.0));
      ASSERT_TRUE(peak.has_value());
      EXPECT_NEAR(peak->shift_cells.x(), dx, kCells);
      EXPECT_NEAR(peak->shift_cells.y(), dy, kCells);
      EXPECT_GT(peak->correlation, 0.9);
    }
}

TEST(PatchCorrelation, BrightnessAndContrastDoNotMatter) {
  auto patch = window_of(21, 2.0, -1.0);
  for (auto& v : patch.values) v = 0.4F * v + 60.0F;
  const auto peak = correlate(patch, window_of(33, 0.0, 0.0));
  ASSERT_TRUE(peak.has_value());
  EXPECT_NEAR(peak->correlation, 1.0, 1e-3);  // single precision sums
}

TEST(PatchCorrelation, NothingWithoutContrastOrValuesOrInsideTheSearch) {
  Window flat{21, std::vector<float>(21 * 21, 90.0F)};
  EXPECT_FALSE(correlate(flat, window_of(33, 0.0, 0.0)).has_value());
  auto holes = window_of(21, 0.0, 0.0);
  for (std::size_t i = 0; i < holes.values.size(); i += 3) holes.values[i] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(correlate(holes, window_of(33, 0.0, 0.0)).has_value());
  EXPECT_FALSE(correlate(window_of(21, 0.0, 0.0), window_of(22, 0.0, 0.0)).has_value());
}

TEST(Robust, MedianAndSigma) {
  EXPECT_EQ(median({}), 0.0);
  EXPECT_EQ(median({3, 1, 2}), 2.0);
  EXPECT_EQ(median({4, 1, 3, 2}), 2.5);
  EXPECT_NEAR(robust_sigma({1, 2, 3, 4, 1000}), 1.4826, 1e-12);
}

}  // namespace
}  // namespace cairn::adjustment
