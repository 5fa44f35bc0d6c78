#include "pipeline/dynamics_stage.hpp"

#include <gtest/gtest.h>

#include <filesystem>

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
    const auto outcome = dynamics_files({block, without}, folder->path(), options, ctx);
    EXPECT_EQ(outcome.summary.at("dynamics").size(), 1U);
  }
  for (const char* name : {"block_dynamics.json", "block_dynamics.svg"})
    EXPECT_EQ(base::read_file(a / name), base::read_file(b / name));
  EXPECT_FALSE(std::filesystem::exists(a / "without_dynamics.json"));
  EXPECT_THROW((void)check_3d(without, {}, options, ctx), base::Error);
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
