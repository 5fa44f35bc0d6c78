#include "tracking/box_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/random.hpp"
#include "tracking/reference_sort.hpp"

namespace {

using namespace cairn;
using geometry::PixelBox;

constexpr double kSamePx = 1e-8;  // px: rounding of a 7 x 7 inverse over a hundred steps; boxes of 1000 px

void expect_same(const PixelBox& a, const PixelBox& b, double tolerance) {
  EXPECT_NEAR(a.xmin, b.xmin, tolerance);
  EXPECT_NEAR(a.ymin, b.ymin, tolerance);
  EXPECT_NEAR(a.xmax, b.xmax, tolerance);
  EXPECT_NEAR(a.ymax, b.ymax, tolerance);
}

PixelBox moving_box(base::Random& random, double t) {
  const double x = 100 + 7 * t + random.normal(), y = 300 - 2 * t + random.normal();
  const double w = 60 + 10 * std::sin(t / 7) + random.normal(), h = 90 + 0.5 * t + random.normal();
  return {x, y, x + w, y + h};
}

TEST(BoxFilter, GivesItsFirstBoxBack) {
  const PixelBox box{10.25, 20.5, 61.0, 100.125};
  expect_same(tracking::BoxFilter(box).box(), box, 1e-12);
}

// The first update from P0: by hand, the centre's gain is (10 + 1e4 + 1) / (10 + 1e4 + 1 + 1) = 10011 / 10012.
TEST(BoxFilter, FirstUpdateTakesTheMeasurementAlmostWhole) {
  tracking::BoxFilter filter({0, 0, 10, 10});
  filter.predict();
  filter.update({10, 0, 20, 10});
  const PixelBox box = filter.box();
  EXPECT_NEAR(0.5 * (box.xmin + box.xmax), 5.0 + 10.0 * 10011.0 / 10012.0, 1e-9);
}

TEST(BoxFilter, EqualsTheFullMatrices) {
  for (const double dt : {1.0, 0.4, 2.5}) {
    base::Random random(3, "box filter", 0);
    const PixelBox first = moving_box(random, 0);
    tracking::BoxFilter filter(first);
    cairn::testing::ReferenceFilter reference(first);
    for (int k = 1; k <= 100; ++k) {
      filter.predict(dt);
      reference.predict(dt);
      expect_same(filter.box(), reference.box(), kSamePx);
      if (k % 5 == 0) continue;
      const PixelBox box = moving_box(random, k * dt);
      filter.update(box);
      reference.update(box);
      expect_same(filter.box(), reference.box(), kSamePx);
    }
  }
}

TEST(BoxFilter, AShrinkingBoxStopsShrinkingBeforeItVanishes) {
  tracking::BoxFilter filter({0, 0, 100, 100});
  filter.predict();
  filter.update({30, 30, 70, 70});
  for (int k = 0; k < 20; ++k) {
    filter.predict();
    const PixelBox box = filter.box();
    ASSERT_TRUE(std::isfinite(box.area()));
    EXPECT_GT(box.area(), 0.0);
  }
}

}  // namespace
