#include "ground/dwa.hpp"

#include <gtest/gtest.h>

#include "ground/costmap.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;
using geometry::Vec2;

class ChooseVelocity : public ::testing::Test {
 protected:
  Grid<std::uint8_t> cost_{{-5.0, 5.0, 0.05, 200, 200}, 0};
  SkidSteerOptions vehicle_;
  DwaOptions options_;
  std::vector<Vec2> path_;
  void SetUp() override {
    for (int i = 0; i <= 80; ++i) path_.emplace_back(0.05 * i, 0.0);
  }
  void block(double west, double south, double east, double north, std::uint8_t value) {
    for (std::size_t r = 0; r < cost_.geometry.rows; ++r)
      for (std::size_t c = 0; c < cost_.geometry.columns; ++c) {
        const Vec2 p = cost_.geometry.centre(r, c);
        if (p.x() > west && p.x() < east && p.y() > south && p.y() < north) cost_.at(r, c) = value;
      }
  }
  [[nodiscard]] DwaChoice choose(const PlanarPose& pose, const DriveVelocity& current) const {
    return choose_velocity(pose, current, cost_, path_, false, vehicle_, options_);
  }
};

TEST_F(ChooseVelocity, GainsSpeedAlongAFreePath) {
  const auto choice = choose({}, {0.5, 0.0});
  ASSERT_TRUE(choice.found);
  EXPECT_DOUBLE_EQ(choice.velocity.forward_m_s, 0.6);  // 1 m/s^2 for a tenth of a second
  EXPECT_DOUBLE_EQ(choice.velocity.turn_rad_s, 0.0);
}

TEST_F(ChooseVelocity, TurnsTowardsThePath) {
  EXPECT_GT(choose({{0.0, 0.0}, -1.0}, {}).velocity.turn_rad_s, 0.0);
  EXPECT_LT(choose({{0.0, 0.0}, 1.0}, {}).velocity.turn_rad_s, 0.0);
  EXPECT_LT(choose({{0.0, 0.5}, 0.0}, {0.5, 0.0}).velocity.turn_rad_s, 0.0);
}

TEST_F(ChooseVelocity, BrakesBeforeAWall) {
  block(1.2, -5.0, 2.0, 5.0, kInscribed);
  const auto choice = choose({}, {1.0, 0.0});
  EXPECT_NEAR(choice.velocity.forward_m_s, 0.8, 1e-12);  // full braking, 2 m/s^2
  for (const auto& p : choice.arc) EXPECT_LT(p.x(), 1.2);
}

TEST_F(ChooseVelocity, TakesUnknownGroundForBlockedUnlessAllowed) {
  block(0.3, -5.0, 2.0, 5.0, kUnknown);
  EXPECT_LT(choose({}, {0.3, 0.0}).velocity.forward_m_s, 0.3);
  EXPECT_GT(choose_velocity({}, {0.3, 0.0}, cost_, path_, true, vehicle_, options_).velocity.forward_m_s, 0.3);
}

TEST_F(ChooseVelocity, LeavesBlockedGroundButEntersNone) {
  block(-0.5, -0.5, 0.1, 0.5, kInscribed);
  const auto out = choose({}, {});
  ASSERT_TRUE(out.found);
  EXPECT_GT(out.velocity.forward_m_s, 0.0);
  block(0.05, -5.0, 5.0, 5.0, kLethal);  // what lies ahead is worse
  EXPECT_EQ(choose({}, {}).velocity.forward_m_s, 0.0);
}

TEST_F(ChooseVelocity, StandsWhereThereIsNoPath) {
  path_.clear();
  const auto choice = choose({}, {0.5, 0.2});
  EXPECT_FALSE(choice.found);
  EXPECT_NEAR(choice.velocity.forward_m_s, 0.3, 1e-12);
}

}  // namespace
}  // namespace cairn::ground
