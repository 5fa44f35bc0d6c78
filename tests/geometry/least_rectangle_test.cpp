#include "geometry/least_rectangle.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/angle.hpp"
#include "base/random.hpp"

namespace cairn::geometry {
namespace {

TEST(LeastRectangle, TurnedBoxFarAway) {
  for (const double azimuth : {0.0, 30.0, 89.0, 135.0}) {
    const double a = base::deg_to_rad(azimuth);
    const Vec2 along(std::sin(a), std::cos(a)), across(std::cos(a), -std::sin(a)), centre(5e5, 3.8e6);
    base::Random random(1, "rectangle", 0);
    std::vector<Vec2> points;
    for (const double s : {-1.0, 1.0})
      for (const double t : {-0.4, 0.4}) points.push_back(centre + s * along + t * across);
    for (int i = 0; i < 50; ++i)
      points.push_back(centre + random.uniform(-1, 1) * along + random.uniform(-.4, .4) * across);
    const auto r = least_area_rectangle(points);
    constexpr double kUtmRounding = 1e-8;  // m
    EXPECT_NEAR(r.length, 2.0, kUtmRounding);
    EXPECT_NEAR(r.width, 0.8, kUtmRounding);
    EXPECT_NEAR(std::remainder(r.length_azimuth_deg - azimuth, 180.0), 0.0, 1e-6);
    EXPECT_LT((r.centre - centre).norm(), kUtmRounding);
  }
}

TEST(LeastRectangle, Degenerate) {
  EXPECT_EQ(least_area_rectangle({}).length, 0.0);
  EXPECT_EQ(least_area_rectangle(std::vector<Vec2>{{3, 4}}).length, 0.0);
  const auto line = least_area_rectangle(std::vector<Vec2>{{0, 0}, {3, 4}, {1.5, 2}});
  EXPECT_NEAR(line.length, 5.0, 1e-12);
  EXPECT_NEAR(line.width, 0.0, 1e-12);
}

}  // namespace
}  // namespace cairn::geometry
