#include "planning/area.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/random.hpp"

namespace {

using cairn::geometry::Ring;
using cairn::geometry::Vec2;
using cairn::planning::Area;
using cairn::planning::check_area;
using ::testing::HasSubstr;

std::string refusal(const Area& area) {
  try {
    check_area(area);
  } catch (const cairn::base::Error& error) {
    EXPECT_EQ(error.code(), cairn::base::ErrorCode::invalid_input);
    return error.what();
  }
  return "";
}

TEST(AreaChecks, RefuseWhatIsNoPolygon) {
  EXPECT_EQ(refusal({{{0, 0}, {10, 0}, {10, 5}, {0, 5}}}), "");
  EXPECT_EQ(refusal({{{0, 0}, {10, 0}, {10, 5}, {5, 1}, {0, 5}}}), "");
  EXPECT_THAT(refusal({{{0, 0}, {10, 5}, {10, 0}, {0, 5}}}), HasSubstr("crosses"));
  EXPECT_THAT(refusal({{{0, 0}, {10, 0}, {10, 5}, {5, 0}, {0, 5}}}), HasSubstr("crosses or touches"));
  EXPECT_THAT(refusal({{{0, 0}, {10, 0}, {5, 0}}}), HasSubstr("back on itself"));
  EXPECT_THAT(refusal({{{0, 0}, {10, 0}}}), HasSubstr("encloses nothing"));
  EXPECT_THAT(refusal({{{0, 0}, {0, 0}, {10, 0}, {10, 5}}}), HasSubstr("same"));
  EXPECT_THAT(refusal({{{0, 0}, {10, std::nan("")}, {10, 5}}}), HasSubstr("not finite"));
  EXPECT_THAT(refusal({}), HasSubstr("no area"));
}

TEST(AreaStrips, ExtentsHoldExactlyWhatLiesInTheStrip) {
  // A U with a hole in its left leg.
  const Area area{{{0, 0}, {30, 0}, {30, 40}, {20, 40}, {20, 10}, {10, 10}, {10, 40}, {0, 40}},
                  {{3, 20}, {7, 20}, {7, 30}, {3, 30}}};
  check_area(area);
  cairn::base::Random random(3, "strips", 0);
  for (int i = 0; i < 50; ++i) {
    const double azimuth = random.uniform(0, std::numbers::pi), low = random.uniform(-40, 40),
                 high = low + random.uniform(0.5, 9);
    const auto extents = cairn::planning::strip_extents(area, azimuth, low, high);
    for (std::size_t k = 1; k < extents.size(); ++k) EXPECT_GT(extents[k].first, extents[k - 1].second);
    const double s = std::sin(azimuth), c = std::cos(azimuth);
    std::vector<double> least(extents.size(), 1e9), most(extents.size(), -1e9);
    for (int k = 0; k < 4000; ++k) {
      const Vec2 p(random.uniform(0, 30), random.uniform(0, 40));
      const double along = p.x() * s + p.y() * c, across = p.x() * c - p.y() * s;
      if (!cairn::planning::inside(area, p) || across < low || across > high) continue;
      bool held = false;
      for (std::size_t e = 0; e < extents.size(); ++e) {
        if (along < extents[e].first - 1e-9 || along > extents[e].second + 1e-9) continue;
        held = true;
        least[e] = std::min(least[e], along);
        most[e] = std::max(most[e], along);
      }
      EXPECT_TRUE(held);
    }
    double length = 0.0;
    for (const auto& e : extents) length += e.second - e.first;
    EXPECT_LT(length, 90.0);
  }
  // Straight up the gap of the U: only its bottom.
  const auto gap = cairn::planning::strip_extents(area, 0.0, 12.0, 18.0);
  ASSERT_EQ(gap.size(), 1U);
  EXPECT_NEAR(gap[0].first, 0.0, 1e-12);
  EXPECT_NEAR(gap[0].second, 10.0, 1e-12);
  // A strip inside the hole's width: two stretches.
  EXPECT_EQ(cairn::planning::strip_extents(area, 0.0, 4.0, 6.0).size(), 2U);
}

TEST(AreaAzimuth, RunsAlongTheLongSide) {
  const double turn = 0.7;
  Ring ring;
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {50.0, 0.0}, {50.0, 12.0}, {0.0, 12.0}})
    ring.emplace_back(x * std::cos(turn) - y * std::sin(turn), x * std::sin(turn) + y * std::cos(turn));
  const double azimuth = cairn::planning::narrowest_azimuth({ring});
  EXPECT_NEAR(azimuth, std::numbers::pi / 2 - turn, 1e-9);
  const auto [low, high] = cairn::planning::across_range({ring}, azimuth);
  EXPECT_NEAR(high - low, 12.0, 1e-9);
}

}  // namespace
