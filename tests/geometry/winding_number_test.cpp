#include "geometry/winding_number.hpp"

#include <gtest/gtest.h>

#include "support/bodies.hpp"

namespace cairn::geometry {
namespace {

using namespace cairn::testing;

constexpr double kRounding = 1e-12;

TEST(WindingNumber, InsideOutsideAndTurned) {
  const auto l_shape = prism({{1, 1}, {1, 2}, {0, 2}, {0, 0}, {2, 0}, {2, 1}}, 2);
  EXPECT_NEAR(winding_number(l_shape, {0.5, 0.5, 1}), 1.0, kRounding);
  EXPECT_NEAR(winding_number(l_shape, {1.5, 1.5, 1}), 0.0, kRounding);  // in the notch
  EXPECT_NEAR(winding_number(l_shape, {9, 9, 9}), 0.0, kRounding);
  EXPECT_NEAR(winding_number(flipped(l_shape), {0.5, 0.5, 1}), -1.0, kRounding);
}

}  // namespace
}  // namespace cairn::geometry
