#include "pipeline/dynamics_stage.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "fragility/subjects.hpp"
#include "support/bodies.hpp"
#include "support/data.hpp"

namespace cairn::pipeline {
namespace {

RockResult assessed_block(double w, double d, double h) {
  RockResult result;
  result.stem = "block";
  result.mesh = testing::block(w, d, h);
  result.rock.target = survey::TargetId(7);
  result.rock.object_class = "rock";
  result.rock.mass = geometry::mass_properties(result.mesh);
  result.rock.density_kg_m3 = 2600.0;
  fragility::Evidence evidence;
  evidence.contact_assumed = false;
  evidence.contact_observed_share = 1.0;
  evidence.width_m = w;
  evidence.height_m = h;
  result.rock.tipping =
      testing::assess_points(
          *result.rock.mass,
          std::vector<geometry::Vec3>(result.mesh.vertices.begin(), result.mesh.vertices.begin() + 4), evidence)
          .tipping;
  return result;
}

// A block rocks about its edges: both engines give the same answers away from the boundary.
TEST(Check3d, BlockAgreesWithThePlaneModel) {
  const auto block = assessed_block(0.5, 1.0, 1.5);
  ASSERT_TRUE(block.rock.tipping.critical);
  DynamicsOptions options;
  options.contact.friction = 2.0;
  options.pulse_ratios_s = "0.08,0.3";
  options.pulse_levels = "1.2,2,4";
  options.step_halvings = 1;
  base::RunContext ctx;
  const auto check = check_3d(block, check_pulses(block.rock, options), options, ctx);
  EXPECT_EQ(check.at("runs").size(), 6U);
  EXPECT_EQ(check.at("compared").as_integer(), 6);
  EXPECT_GE(check.at("same_answer").as_integer(), 5);
  EXPECT_GT(check.at("toppled_3d").as_integer(), 0);
  EXPECT_LT(check.at("toppled_3d").as_integer(), 6);
  EXPECT_TRUE(check.at("step_converged").as_bool());
  for (const auto& run : check.at("runs").as_array())
    if (!run.at("toppled_3d").as_bool() && !run.at("toppled_plane").as_bool()) {
      const double share = run.at("max_tilt_deg").as_real() / 18.434949;
      EXPECT_NEAR(share, run.at("max_tilt_plane_share").as_real(), 0.05) << run.at("motion").as_string();
    }
}

TEST(Check3d, WritesTheSameBytesAndSkipsWhatHasNoAngle) {
  auto block = assessed_block(0.5, 1.0, 1.5);
  auto without = block;
  without.stem = "without";
  without.rock.tipping.critical.reset();
  DynamicsOptions options;
  options.pulse_ratios_s = "0.1";
  options.pulse_levels = "1.5,3";
  options.step_halvings = 0;
  base::RunContext ctx;
  const testing::TempFolder a, b;
  for (const auto* folder : {&a, &b}) {
    const auto outcome = dynamics_files({block, without}, {}, {}, folder->path(), options, ctx);
    EXPECT_EQ(outcome.summary.at("dynamics").size(), 1U);
  }
  for (const char* name : {"block_dynamics.json", "block_dynamics.svg"})
    EXPECT_EQ(base::read_file(a / name), base::read_file(b / name));
  EXPECT_FALSE(std::filesystem::exists(a / "without_dynamics.json"));
  EXPECT_THROW((void)check_3d(without, {}, options, ctx), base::Error);
}

// A record runs along the critical azimuth, its first push away from it, once a scale; PGV/PGA does not scale.
TEST(Check3d, RecordsRunAlongTheCriticalAzimuth) {
  const auto block = assessed_block(0.5, 1.0, 1.5);
  survey::Accelerogram record, up;
  record.name = "pulse";
  record.dt_s = 0.01;
  for (int i = 0; i <= 100; ++i) record.acceleration.push_back(i < 50 ? 2.0 : -2.0);
  up = record;
  up.vertical = true;
  const std::vector<double> scales = {1.0, 3.0};
  const auto motions = check_record_motions(block.rock, std::vector{record, up}, scales);
  ASSERT_EQ(motions.size(), 2U);
  EXPECT_NEAR(motions[1].pga_g, 6.0 / 9.80665, 1e-12);
  EXPECT_NEAR(motions[0].pgv_over_pga_s, motions[1].pgv_over_pga_s, 1e-12);
  EXPECT_NEAR(motions[0].pgv_over_pga_s, 0.5, 0.01);
  const double azimuth = block.rock.tipping.critical->azimuth_deg * std::numbers::pi / 180.0;
  EXPECT_LT(motions[0].motion.velocity(0.2).dot(geometry::Vec3(std::sin(azimuth), std::cos(azimuth), 0.0)), -0.3);
  DynamicsOptions options;
  options.step_halvings = 0;
  options.contact.friction = 2.0;
  base::RunContext ctx;
  const auto check = check_3d(block, motions, options, ctx);
  EXPECT_FALSE(check.at("runs").as_array().at(0).at("toppled_3d").as_bool());
  EXPECT_EQ(check.at("runs").as_array().at(0).at("outcome_3d").as_string(), "rested");  // 2 m/s^2 < g/3
  EXPECT_TRUE(check.at("runs").as_array().at(1).at("toppled_3d").as_bool());
  EXPECT_EQ(check.at("same_answer").as_integer(), 2);
}

TEST(Check3d, RefusesListsThatAreNoNumbers) {
  const auto block = assessed_block(0.5, 1.0, 1.5);
  DynamicsOptions options;
  for (const char* bad : {"", "0.1,", "0.1;0.2", "-1", "0", "inf", "x"}) {
    options.pulse_levels = bad;
    EXPECT_THROW((void)check_pulses(block.rock, options), base::Error) << bad;
  }
}

}  // namespace
}  // namespace cairn::pipeline
