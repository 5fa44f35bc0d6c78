#include "detection/letterbox.hpp"

#include <gtest/gtest.h>

namespace {

using namespace cairn::detection;
using cairn::geometry::PixelBox;

constexpr double kRounding = 1e-9;  // px

TEST(Letterbox, WideImageIsPaddedAboveAndBelow) {
  const auto fit = letterbox({0, 0, 1280, 720}, {640, 640});
  EXPECT_EQ(fit.scaled_width, 640U);
  EXPECT_EQ(fit.scaled_height, 360U);
  EXPECT_EQ(fit.pad_x, 0U);
  EXPECT_EQ(fit.pad_y, 140U);
  // By hand: the image's corner is at (0, 140), its middle at (320, 320).
  const auto corner = fit.to_image({0, 140, 320, 320});
  EXPECT_NEAR(corner.xmin, 0.0, kRounding);
  EXPECT_NEAR(corner.ymin, 0.0, kRounding);
  EXPECT_NEAR(corner.xmax, 640.0, kRounding);
  EXPECT_NEAR(corner.ymax, 360.0, kRounding);
}

TEST(Letterbox, APartKeepsItsPlace) {
  const auto fit = letterbox({300, 200, 320, 320}, {320, 320});
  const auto b = fit.to_image({10, 20, 30, 40});
  EXPECT_NEAR(b.xmin, 310.0, kRounding);
  EXPECT_NEAR(b.ymin, 220.0, kRounding);
}

TEST(Letterbox, RoundTripForAnySize) {
  for (const std::size_t w : {1U, 17U, 333U, 1600U, 5472U})
    for (const std::size_t h : {1U, 31U, 900U, 3648U}) {
      const auto fit = letterbox({5, 7, w, h}, {640, 480});
      EXPECT_TRUE(fit.scaled_width == 640 || fit.scaled_height == 480);
      EXPECT_LE(fit.pad_x + fit.scaled_width, 640U);
      EXPECT_LE(fit.pad_y + fit.scaled_height, 480U);
      const PixelBox b{5.0, 7.0, 5.0 + static_cast<double>(w), 7.0 + 0.5 * static_cast<double>(h)};
      const PixelBox back = fit.to_image(fit.to_input(b));
      EXPECT_NEAR(back.xmin, b.xmin, 1e-6);
      EXPECT_NEAR(back.ymax, b.ymax, 1e-6);
      EXPECT_NEAR(back.xmax, b.xmax, 1e-6);
    }
}

}  // namespace
