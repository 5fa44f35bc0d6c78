#include "ground/drive.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"
#include "ground/costmap.hpp"

namespace cairn::ground {
namespace {

using geometry::Grid;
using geometry::Vec2;

constexpr double kTick_s = 0.1;

// 20 m x 12 m of free ground at 0.1 m with walls, inflated.
struct World {
  OccupancyGrid occupancy = OccupancyGrid(geometry::GridGeometry{0.0, 12.0, 0.1, 200, 120}, Occupancy::free);
  CostmapOptions options{0.35, 3.0, 0.1};

  void wall(double west, double south, double east, double north) {
    for (std::size_t r = 0; r < 120; ++r)
      for (std::size_t c = 0; c < 200; ++c) {
        const Vec2 p = occupancy.geometry.centre(r, c);
        if (p.x() > west && p.x() < east && p.y() > south && p.y() < north) occupancy.at(r, c) = Occupancy::occupied;
      }
  }
  [[nodiscard]] Grid<std::uint8_t> cost() const { return costmap(occupancy, options); }
};

struct Driven {
  DriveStatus status = DriveStatus::driving;
  double length_m = 0.0, time_s = 0.0;
  std::uint8_t worst_cost = 0;  // of the true map, where the vehicle was
  double fastest_gain = 0.0, fastest_loss = 0.0;
};

// Drives in `truth`, which becomes known (all of it) when the vehicle passes east of `known_from`.
Driven drive(Driver& driver, PlanarPose pose, const World& prior, const World& truth, double known_from,
             double limit_s) {
  base::RunContext ctx;
  const auto before = prior.cost(), after = truth.cost();
  Driven driven;
  DriveVelocity velocity;
  const Vec2 start = pose.position;
  Vec2 last = start;
  bool known = false;
  for (int i = 0; i * kTick_s < limit_s; ++i) {
    known = known || pose.position.x() > known_from;
    const auto tick =
        driver.tick(static_cast<std::int64_t>(i) * 100'000'000, pose, velocity, known ? after : before, ctx);
    driven.status = tick.status;
    if (tick.status == DriveStatus::arrived) break;
    const double change = std::abs(tick.command.forward_m_s) - std::abs(velocity.forward_m_s);
    driven.fastest_gain = std::max(driven.fastest_gain, change / kTick_s);
    driven.fastest_loss = std::max(driven.fastest_loss, -change / kTick_s);
    velocity = tick.command;
    pose = moved(pose, velocity, kTick_s);
    driven.length_m += (pose.position - last).norm();
    driven.time_s += kTick_s;
    last = pose.position;
    const auto cell = after.geometry.cell_at(pose.position);
    driven.worst_cost = std::max(driven.worst_cost, cell ? after.at(cell->first, cell->second) : kUnknown);
  }
  return driven;
}

TEST(Driver, ReachesTheGoalOverFreeGround) {
  const World world;
  Driver driver({18.0, 6.0}, {});
  const auto driven = drive(driver, {{2.0, 6.0}, 0.0}, world, world, -1.0, 60.0);
  EXPECT_EQ(driven.status, DriveStatus::arrived);
  EXPECT_LT(driven.length_m, 16.1);
  EXPECT_LT(driven.time_s, 19.0);  // 16 m at 1 m/s, 1 s to gain speed and as long to lose it before the goal
  EXPECT_EQ(driver.replans(), 0U);
  EXPECT_LE(driven.fastest_gain, 1.0 + 1e-9);
  EXPECT_LE(driven.fastest_loss, 2.0 + 1e-9);
}

TEST(Driver, StraightPathsAreShorter) {
  const World world;
  DriverOptions rough;
  rough.smooth = false;
  Driver straight({18.0, 9.0}, {}), steps({18.0, 9.0}, rough);
  const auto a = drive(straight, {{2.0, 3.0}, 0.3}, world, world, -1.0, 60.0);
  const auto b = drive(steps, {{2.0, 3.0}, 0.3}, world, world, -1.0, 60.0);
  ASSERT_EQ(a.status, DriveStatus::arrived);
  ASSERT_EQ(b.status, DriveStatus::arrived);
  // 17.09 m as the crow flies, 18.5 m in steps of a grid, each less the tolerance of the goal.
  EXPECT_LT(a.length_m, 17.0);
  EXPECT_GT(b.length_m, 17.5);
}

TEST(Driver, TurnsRoundWhereTheGoalIsBehind) {
  const World world;
  Driver driver({2.0, 6.0}, {});
  const auto driven = drive(driver, {{10.0, 6.0}, 0.0}, world, world, -1.0, 60.0);
  EXPECT_EQ(driven.status, DriveStatus::arrived);
  EXPECT_LT(driven.length_m, 10.0);
}

TEST(Driver, GoesRoundAWallWithoutTouchingIt) {
  World world;
  world.wall(9.0, 2.0, 9.5, 12.0);
  Driver driver({14.0, 10.0}, {});
  const auto driven = drive(driver, {{4.0, 10.0}, 1.0}, world, world, -1.0, 120.0);
  EXPECT_EQ(driven.status, DriveStatus::arrived);
  EXPECT_LT(driven.worst_cost, kInscribed);
}

TEST(Driver, PlansAnewWhereItsPathTurnsOutBlocked) {
  const World prior;
  World truth;
  truth.wall(9.0, 3.0, 9.5, 12.0);
  Driver driver({16.0, 8.0}, {});
  const auto driven = drive(driver, {{2.0, 8.0}, 0.0}, prior, truth, 7.0, 120.0);
  EXPECT_EQ(driven.status, DriveStatus::arrived);
  EXPECT_LT(driven.worst_cost, kInscribed);
  EXPECT_EQ(driver.replans(), 1U);
}

TEST(Driver, ComesOutOfADeadEnd) {
  const World prior;
  World truth;  // a pocket that opens to the west
  truth.wall(9.0, 3.0, 9.5, 9.0);
  truth.wall(5.0, 8.5, 9.5, 9.0);
  truth.wall(5.0, 3.0, 9.5, 3.5);
  Driver driver({16.0, 6.0}, {});
  const auto driven = drive(driver, {{2.0, 6.0}, 0.0}, prior, truth, 7.5, 200.0);
  EXPECT_EQ(driven.status, DriveStatus::arrived);
  EXPECT_LT(driven.worst_cost, kInscribed);
  EXPECT_EQ(driver.replans(), 1U);
}

TEST(Driver, TakesAWayThatOpens) {
  World prior;
  prior.wall(9.0, 2.0, 9.5, 12.0);
  const World truth;
  Driver driver({16.0, 10.0}, {});
  const auto driven = drive(driver, {{2.0, 10.0}, 0.0}, prior, truth, 3.0, 120.0);
  EXPECT_EQ(driven.status, DriveStatus::arrived);
  EXPECT_EQ(driver.replans(), 1U);
  EXPECT_LT(driven.length_m, 20.0);
}

TEST(Driver, PassesAGapTwoCellsWiderThanItself) {
  World world;
  world.wall(9.0, 6.5, 9.5, 12.0);
  world.wall(9.0, 0.0, 9.5, 5.5);
  Driver driver({16.0, 9.0}, {});
  const auto driven = drive(driver, {{2.0, 9.0}, 0.0}, world, world, -1.0, 120.0);
  EXPECT_EQ(driven.status, DriveStatus::arrived);
  EXPECT_LT(driven.worst_cost, kInscribed);
}

TEST(Driver, SaysWhyItStands) {
  World closed;
  closed.wall(9.0, -1.0, 9.5, 13.0);
  const World open;
  base::RunContext ctx;
  const auto reason = [&](const Vec2& from, const Vec2& to, const World& world) {
    Driver driver(to, {});
    const auto tick = driver.tick(0, {from, 0.0}, {}, world.cost(), ctx);
    EXPECT_EQ(tick.command, DriveVelocity{});
    return tick.status == DriveStatus::blocked ? tick.reason : "";
  };
  EXPECT_EQ(reason({2.0, 6.0}, {16.0, 6.0}, closed), "no_path");
  EXPECT_EQ(reason({2.0, 6.0}, {30.0, 6.0}, open), "goal_outside");
  EXPECT_EQ(reason({-2.0, 6.0}, {16.0, 6.0}, open), "start_outside");
  World filled = open;
  filled.wall(15.0, 5.0, 17.0, 7.0);
  EXPECT_EQ(reason({2.0, 6.0}, {16.0, 6.0}, filled), "goal_blocked");
  EXPECT_EQ(reason({16.0, 6.0}, {2.0, 6.0}, filled), "start_blocked");
  EXPECT_THROW(Driver({std::nan(""), 0.0}, {}), base::Error);
}

TEST(Driver, GoesOnWhereTheWayIsFreeAgain) {
  World closed;
  closed.wall(9.0, -1.0, 9.5, 13.0);
  const World open;
  Driver driver({16.0, 6.0}, {});
  base::RunContext ctx;
  EXPECT_EQ(driver.tick(0, {{2.0, 6.0}, 0.0}, {}, closed.cost(), ctx).status, DriveStatus::blocked);
  EXPECT_EQ(driver.tick(2'000'000'000, {{2.0, 6.0}, 0.0}, {}, open.cost(), ctx).status, DriveStatus::driving);
}

}  // namespace
}  // namespace cairn::ground
