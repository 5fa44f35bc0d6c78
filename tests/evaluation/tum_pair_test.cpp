// A recorded pair (TUM RGB-D fr2/desk, tests/data/tum) against the same definitions computed with numpy and scipy.
#include <gtest/gtest.h>

#include <fstream>

#include "base/error.hpp"
#include "io/tum_trajectory.hpp"
#include "pipeline/evaluate_stage.hpp"
#include "support/data.hpp"

namespace {

using cairn::io::Json;
using cairn::testing::test_data;

constexpr double kOracle = 1e-7;  // m, deg: quaternions are normalised in another order there

Json score(const std::string& align) {
  cairn::base::RunContext ctx;
  cairn::pipeline::EvaluateOptions options;
  options.trajectory.align = align;
  return cairn::pipeline::evaluate_trajectory(
             {.result = test_data("tum/fr2_desk_orb.txt"), .truth = test_data("tum/fr2_desk_groundtruth.txt")}, options,
             ctx)
      .summary;
}

TEST(TumPair, Se3) {
  const Json s = score("se3");
  EXPECT_EQ(s.at("poses").as_integer(), 700);
  EXPECT_EQ(s.at("pairs").as_integer(), 598);
  EXPECT_EQ(s.at("match").as_string(), "time");
  EXPECT_NEAR(s.at("ate").at("rmse_m").as_real(), 0.006922371176107097, kOracle);
  EXPECT_NEAR(s.at("ate").at("mean_m").as_real(), 0.006210462359806384, kOracle);
  EXPECT_NEAR(s.at("ate").at("median_m").as_real(), 0.005646680035883524, kOracle);
  EXPECT_NEAR(s.at("ate").at("max_m").as_real(), 0.019358760824730648, kOracle);
  EXPECT_NEAR(s.at("ate_rotation_deg").at("rmse").as_real(), 1.2025674138699458, kOracle);
  EXPECT_EQ(s.at("rpe").at("pairs").as_integer(), 597);
  EXPECT_NEAR(s.at("rpe").at("translation_m").at("rmse").as_real(), 0.003437780941136343, kOracle);
  EXPECT_NEAR(s.at("rpe").at("rotation_deg").at("rmse").as_real(), 0.33915288637787666, kOracle);
}

TEST(TumPair, Sim3) {
  const Json s = score("sim3");
  EXPECT_NEAR(s.at("T_truth_estimate").at("scale").as_real(), 0.9961618020679358, kOracle);
  EXPECT_NEAR(s.at("ate").at("rmse_m").as_real(), 0.005591471755803916, kOracle);
  EXPECT_NEAR(s.at("ate").at("max_m").as_real(), 0.021129141686760236, kOracle);
  EXPECT_NEAR(s.at("rpe").at("translation_m").at("rmse").as_real(), 0.003429661348989895, kOracle);
}

TEST(TumReader, ExactTimesAndBadRows) {
  const cairn::testing::TempFolder folder;
  const auto write = [&](const std::string& text) {
    std::ofstream(folder / "t.txt") << text;
    return folder / "t.txt";
  };
  const auto poses = cairn::io::read_tum(write("# comment\n1311868164.363181 1 2 3 0 0 0 1\n5 0 0 0 0 0 0.6 0.8\n"));
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[0].time_ns, 1311868164363181000);
  EXPECT_EQ(poses[1].time_ns, 5000000000);
  EXPECT_NEAR(poses[1].T_world_body.rotation(0, 0), 0.8 * 0.8 - 0.6 * 0.6, 1e-12);
  for (const char* bad : {"1 2 3\n", "1 0 0 0 0 0 0 2\n", "1 x 0 0 0 0 0 1\n", "1 nan 0 0 0 0 0 1\n", "# nothing\n",
                          "1e300 0 0 0 0 0 0 1\n", "1 2 3 4 5 6 7 8 9\n"})
    EXPECT_THROW(static_cast<void>(cairn::io::read_tum(write(bad))), cairn::base::Error) << bad;
  EXPECT_THROW(static_cast<void>(cairn::io::read_tum(folder / "none")), cairn::base::Error);
}

}  // namespace
