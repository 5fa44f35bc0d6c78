#include "dynamics/topple.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "dynamics/rocking_reference.hpp"
#include "support/bodies.hpp"

namespace cairn::dynamics {
namespace {

using geometry::Vec3;
using testing::PlaneBlock;

RigidRock block_rock(double w, double d, double h, const Vec3& offset = Vec3::Zero()) {
  const auto mesh = testing::moved(testing::block(w, d, h), offset);
  return rigid_rock(mesh, geometry::mass_properties(mesh), 2600.0,
                    std::vector<Vec3>(mesh.vertices.begin(), mesh.vertices.begin() + 4));
}

// High friction, so that the block rocks as the plane model assumes.
ToppleOptions rocking_options() {
  ToppleOptions options;
  options.friction = 5.0;
  return options;
}

TEST(Topple, ARockAtRestStaysAtRest) {
  const auto result = topple(block_rock(1, 1, 3), BaseMotion{});
  EXPECT_EQ(result.outcome, ToppleOutcome::rested);
  EXPECT_LT(result.max_tilt_rad, 1e-9);
  EXPECT_LT(result.slip_m, 1e-9);
  EXPECT_LT(result.time_s, 1.0);
}

TEST(Topple, FallsFreelyAtG) {
  const auto rock = block_rock(1, 1, 3);
  ToppleOptions options;
  options.sample_s = 0.1;
  options.settle_s = 0.4;
  BodyStart start;
  start.T_world_start.translation = {0, 0, 5};
  const auto result = topple(rock, BaseMotion{}, options, start);
  ASSERT_GE(result.path.size(), 5U);
  for (const auto& s : result.path) {
    const double fallen = 5.0 - s.displacement_m.z();
    // Semi-implicit Euler is ahead by g t dt / 2.
    EXPECT_NEAR(fallen, 0.5 * testing::kG * s.time_s * (s.time_s + options.step_s), 1e-9) << s.time_s;
    EXPECT_LT(s.rotation_vector_rad.norm(), 1e-12);
  }
}

// A block let go from half its angle loses energy at every impact and never gains any.
TEST(Topple, NeverGainsEnergy) {
  const auto rock = block_rock(1, 1, 3);
  const PlaneBlock plane{0.5, 1.5};
  auto options = rocking_options();
  options.sample_s = 0.01;
  BodyStart start;
  // Turn about the edge x = +0.5.
  const double tilt = 0.5 * plane.alpha();
  start.T_world_start.rotation = geometry::axis_rotation(Vec3::UnitY(), tilt);
  start.T_world_start.translation = Vec3(0.5, 0, 0) - start.T_world_start.rotation * Vec3(0.5, 0, 0);
  const auto result = topple(rock, BaseMotion{}, options, start);
  EXPECT_EQ(result.outcome, ToppleOutcome::rocked);
  EXPECT_GT(result.impacts, 4);
  const double first = result.path.front().energy_j;
  EXPECT_GT(first, 0.0);
  // The integrator's own ripple, first order in the step: 1e-3 of the energy at 0.5 ms.
  const double ripple = 2e-3 * first;
  double least = first;
  for (const auto& s : result.path) {
    EXPECT_LE(s.energy_j, least + ripple) << s.time_s;
    least = std::min(least, s.energy_j);
  }
  EXPECT_NEAR(result.path.back().energy_j, 0.0, ripple);
}

// The first impact takes what Housner says: rate ratio eta = 1 - 1.5 sin^2(alpha), energy eta^2.
TEST(Topple, ImpactsLoseWhatHousnerSays) {
  for (const double height : {2.0, 3.0, 5.0}) {
    const auto rock = block_rock(1, 1, height);
    const PlaneBlock plane{0.5, height / 2};
    auto options = rocking_options();
    options.step_s = 1e-4;
    options.sample_s = 1e-3;
    options.settle_s = 3.0;
    BodyStart start;
    const double tilt = 0.3 * plane.alpha();
    start.T_world_start.rotation = geometry::axis_rotation(Vec3::UnitY(), tilt);
    start.T_world_start.translation = Vec3(0.5, 0, 0) - start.T_world_start.rotation * Vec3(0.5, 0, 0);
    const auto result = topple(rock, BaseMotion{}, options, start);
    // Energy just before and after the first change of the side it leans to.
    std::size_t k = 0;
    while (k < result.path.size() && result.path[k].rotation_vector_rad.y() > 0.0) ++k;
    ASSERT_GT(k, 10U);
    ASSERT_LT(k + 5, result.path.size());
    const double ratio = std::sqrt(result.path[k + 5].energy_j / result.path[k - 5].energy_j);
    EXPECT_NEAR(ratio, plane.eta(), 0.01) << height;
  }
}

// fragility.md 2.3: the least velocity step that topples, exact for a rigid block.
TEST(Topple, TopplesFromTheLeastVelocityStep) {
  const auto rock = block_rock(1, 1, 3);
  const double v_min = PlaneBlock{0.5, 1.5}.v_min();
  EXPECT_NEAR(v_min, 1.535458, 1e-6);
  const auto step_motion = [](double v) { return BaseMotion{1e-4, {Vec3(-v, 0, 0)}}; };
  const auto below = topple(rock, step_motion(0.985 * v_min), rocking_options());
  const auto above = topple(rock, step_motion(1.015 * v_min), rocking_options());
  EXPECT_EQ(below.outcome, ToppleOutcome::rocked);
  EXPECT_EQ(above.outcome, ToppleOutcome::toppled);
  EXPECT_NEAR(above.tilt_toward_deg, 90.0, 1.0);
}

// Nothing moves below g tan(alpha); above it the block rocks.
TEST(Topple, StartsToRockAtGTanAlpha) {
  const auto rock = block_rock(1, 1, 3);
  const double start = testing::kG / 3.0;
  const auto push = [](double a) {
    std::vector<Vec3> record(40, Vec3(a, 0, 0));
    return from_acceleration(0.01, record);
  };
  EXPECT_EQ(topple(rock, push(0.98 * start), rocking_options()).outcome, ToppleOutcome::rested);
  EXPECT_EQ(topple(rock, push(1.03 * start), rocking_options()).outcome, ToppleOutcome::rocked);
}

// Pulses of one cosine over a plane of PGA and PGV/PGA: the answers and the greatest angles of the plane model.
TEST(Topple, AgreesWithThePlaneModelUnderPulses) {
  const PlaneBlock plane{0.25, 0.75};
  const auto rock = block_rock(0.5, 0.5, 1.5, Vec3(500000, 3.8e6, 1500));
  int toppled = 0, agree = 0, count = 0;
  for (const double pga : {0.36, 0.45, 0.6, 0.9})
    for (const double ratio : {0.05, 0.1, 0.2, 0.3}) {
      const double a = pga * testing::kG, w = 1.0 / ratio, period = 2 * std::numbers::pi * ratio;
      const auto reference = testing::rock_plane(
          plane, [&](double t) { return t < period ? a * std::cos(w * t) : 0.0; }, period + 6.0);
      const auto result = topple(rock, one_cosine(a, ratio, 90.0), rocking_options());
      ++count;
      toppled += reference.toppled ? 1 : 0;
      agree += reference.toppled == result.toppled() ? 1 : 0;
      if (!reference.toppled && !result.toppled()) {
        EXPECT_NEAR(result.max_tilt_rad, reference.greatest, 0.06 * reference.greatest + 1e-3) << pga << " " << ratio;
      }
    }
  EXPECT_GE(toppled, 3);
  EXPECT_LE(toppled, count - 3);
  EXPECT_GE(agree, count - 1);  // one may lie on the boundary
}

// Dropped flat from h, a body comes back to e^2 h.
TEST(Topple, BouncesByTheRestitutionDeclared) {
  constexpr double kHeight = 0.5, kRestitution = 0.6;
  ToppleOptions options;
  options.restitution = kRestitution;
  options.step_s = 1e-4;
  options.sample_s = 1e-3;
  options.settle_s = 0.8;
  BodyStart start;
  start.T_world_start.translation = {0, 0, kHeight};
  const auto result = topple(block_rock(1, 1, 1), BaseMotion{}, options, start);
  double peak = 0.0;
  bool landed = false;
  for (const auto& s : result.path) {
    landed = landed || s.displacement_m.z() < 0.01;
    if (landed) peak = std::max(peak, s.displacement_m.z());
  }
  EXPECT_NEAR(peak, kRestitution * kRestitution * kHeight, 0.005);
}

// On springs the body sinks by its weight over their stiffness.
TEST(Topple, SinksIntoTheStiffnessDeclared) {
  const auto rock = block_rock(1, 1, 1);
  ToppleOptions options;
  options.stiffness_n_m = 1e6;
  options.damping_ns_m = 5e4;
  options.sample_s = 0.1;
  const auto result = topple(rock, BaseMotion{}, options);
  const double sag = rock.mass_kg * testing::kG / (4 * options.stiffness_n_m);
  EXPECT_NEAR(result.path.back().displacement_m.z(), -sag, 0.02 * sag);
  EXPECT_LT(result.max_tilt_rad, 1e-6);
}

TEST(Topple, SlidesOnLowFriction) {
  ToppleOptions options;
  options.friction = 0.1;
  const auto result = topple(block_rock(1, 1, 3), one_cosine(0.6 * testing::kG, 0.1, 0.0), options);
  EXPECT_FALSE(result.toppled());
  EXPECT_GT(result.slip_m, 0.05);
}

TEST(Topple, FallsOffWhenItSlipsTooFar) {
  ToppleOptions options;
  options.friction = 0.02;
  const BaseMotion jerk{1e-3, {Vec3(2.0, 0, 0)}};
  EXPECT_EQ(topple(block_rock(1, 1, 1), jerk, options).outcome, ToppleOutcome::fell_off);
}

// A mushroom on level ground wider than its foot is stopped by its own cap; on a pedestal no wider than the foot not.
TEST(Topple, FlanksStrikeThePlane) {
  const auto mesh = testing::frustum(0.2, 1.0, 1.0, 48);
  const auto rock = rigid_rock(mesh, geometry::mass_properties(mesh), 2600.0,
                               std::vector<Vec3>(mesh.vertices.begin(), mesh.vertices.begin() + 48));
  const BaseMotion step{1e-3, {Vec3(-1.5, 0, 0)}};
  auto options = rocking_options();
  const auto free = topple(rock, step, options);
  EXPECT_EQ(free.outcome, ToppleOutcome::toppled);
  options.surround = "plane";
  options.topple_angle_deg = 80.0;
  const auto stopped = topple(rock, step, options);
  // The flank slopes by atan(1 / 0.8) = 51.3 deg: the cap lands there.
  EXPECT_FALSE(stopped.toppled());
  EXPECT_NEAR(stopped.max_tilt_rad, std::atan(1.0 / 0.8), 0.05);
}

TEST(Topple, GivesTheSameBytesOnEachRun) {
  const auto rock = block_rock(0.5, 0.6, 1.5);
  ToppleOptions options;
  options.sample_s = 0.01;
  const auto motion = one_cosine(0.4 * testing::kG, 0.15, 30.0);
  const auto a = topple(rock, motion, options), b = topple(rock, motion, options);
  ASSERT_EQ(a.path.size(), b.path.size());
  for (std::size_t i = 0; i < a.path.size(); ++i) {
    EXPECT_EQ(a.path[i].rotation_vector_rad, b.path[i].rotation_vector_rad);
    EXPECT_EQ(a.path[i].energy_j, b.path[i].energy_j);
  }
  EXPECT_EQ(a.max_tilt_rad, b.max_tilt_rad);
}

TEST(StepConvergence, GreatestTiltConvergesInTheStep) {
  ToppleOptions options = rocking_options();
  options.step_s = 2e-3;
  const auto study = step_convergence(block_rock(0.5, 0.5, 1.5), one_cosine(0.5 * testing::kG, 0.08, 90.0), options, 4);
  ASSERT_EQ(study.rows.size(), 5U);
  EXPECT_TRUE(study.converged);
  const double finest = study.rows.back().max_tilt_rad;
  EXPECT_LT(std::abs(study.rows[3].max_tilt_rad - finest), std::abs(study.rows[0].max_tilt_rad - finest));
}

TEST(Topple, RefusesOptionsOutOfRange) {
  ToppleOptions options;
  options.step_s = 0.0;
  EXPECT_THROW((void)topple(block_rock(1, 1, 3), BaseMotion{}, options), base::Error);
  EXPECT_THROW((void)topple(RigidRock{}, BaseMotion{}), base::Error);
}

}  // namespace
}  // namespace cairn::dynamics
