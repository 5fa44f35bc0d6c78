#include "localisation/association.hpp"

#include <gtest/gtest.h>

#include "geometry/assignment.hpp"

namespace cairn::localisation {
namespace {

using geometry::kUnassigned;
using geometry::PixelBox;

View forward() {
  View view;  // at the origin, looking along +z
  view.fx_px = view.fy_px = 100.0;
  return view;
}

TEST(CountInside, CountsPointsOfEachBox) {
  Points points(4, 3);
  points << 0, 0, 1, 0.1, 0, 1, 0.5, 0.5, 1, 0, 0, -1;
  const std::vector<PixelBox> boxes{{-1, -1, 20, 1}, {40, 40, 60, 60}, {200, 200, 300, 300}};
  EXPECT_EQ(count_inside(points, forward(), boxes, true), (std::vector<std::size_t>{2, 1, 0}));
  // Without the test for depth, the point behind the camera projects into the first box.
  EXPECT_EQ(count_inside(points, forward(), boxes, false), (std::vector<std::size_t>{3, 1, 0}));
  EXPECT_TRUE(count_inside(points, forward(), {}, true).empty());
}

TEST(Associate, MaximisesTheTotalNotTheSinglePair) {
  // Target 0 has 10 points in box 0, but giving it box 1 lets target 1 have box 0: 9 + 8 > 10 + 0.
  EXPECT_EQ(associate({10, 9, 8, 0}, 2, 2, 1.0), (std::vector<std::size_t>{1, 0}));
}

TEST(Associate, RefusesPairsBelowTheGate) {
  EXPECT_EQ(associate({99, 0, 0, 100}, 2, 2, 100.0), (std::vector<std::size_t>{kUnassigned, 1}));
  // A gate of 0 still needs one point.
  EXPECT_EQ(associate({0}, 1, 1, 0.0), (std::vector<std::size_t>{kUnassigned}));
  EXPECT_EQ(associate({}, 1, 0, 0.0), (std::vector<std::size_t>{kUnassigned}));
}

}  // namespace
}  // namespace cairn::localisation
