#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "ground/costmap.hpp"
#include "io/json.hpp"
#include "io/ros_map.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"
#include "support/small_ground.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class CostmapCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string surface_ = (folder_ / "surface.tif").string(), obstacles_ = (folder_ / "obstacles.json").string(),
              out_ = (folder_ / "out").string();
  void SetUp() override { cairn::testing::write_small_ground(folder_.path()); }
  [[nodiscard]] cairn::testing::ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"costmap", "--obstacles", obstacles_, "--surface", surface_, "-o", out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return cairn(arguments);
  }
};

TEST_F(CostmapCommand, WritesRasterMapAndRecord) {
  const auto result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("columns").as_integer(), 200);
  EXPECT_EQ(summary.at("rows").as_integer(), 160);
  constexpr double kCellArea = 0.0025;
  EXPECT_NEAR(summary.at("unknown_m2").as_real(), 4.0, kCellArea);
  EXPECT_NEAR(summary.at("occupied_m2").as_real(), 0.785, 0.02);  // a disc of 1 m on cells of 5 cm; no tree
  const auto raster = cairn::io::read_raster(fs::path(out_) / "costmap.tif");
  const auto& cost = std::get<cairn::geometry::Grid<std::uint8_t>>(raster.bands.at(0).values);
  EXPECT_EQ(cost.geometry.west, 0.0);
  EXPECT_EQ(cost.geometry.north, 8.0);
  const auto value = [&](double e, double n) {
    const auto cell = cost.geometry.cell_at({e, n});
    return cost.at(cell->first, cell->second);
  };
  EXPECT_EQ(value(5.01, 4.01), cairn::ground::kLethal);
  EXPECT_EQ(value(5.70, 4.01), cairn::ground::kInscribed);
  EXPECT_EQ(value(2.01, 2.01), 0);
  EXPECT_EQ(value(9.0, 7.0), cairn::ground::kUnknown);
  const auto map = cairn::io::read_ros_map(fs::path(out_) / "map.yaml");
  EXPECT_EQ(map.occupancy.geometry, cost.geometry);
  EXPECT_THAT(cairn::base::read_file(fs::path(out_) / "map.yaml"), HasSubstr("free_thresh: 0.1"));
  EXPECT_TRUE(fs::exists(fs::path(out_) / "run.json"));
}

TEST_F(CostmapCommand, RefusesAnExistingOutputAndReplacesItWhenTold) {
  ASSERT_EQ(run().exit_code, 0);
  const auto again = run();
  EXPECT_EQ(again.exit_code, 7);
  EXPECT_THAT(again.err, HasSubstr("--overwrite"));
  EXPECT_EQ(run({"--overwrite"}).exit_code, 0);
}

TEST_F(CostmapCommand, SameBytesForAnyThreadCount) {
  ASSERT_EQ(run({"--threads", "1"}).exit_code, 0);
  const auto one = cairn::base::read_file(fs::path(out_) / "costmap.tif");
  ASSERT_EQ(run({"--threads", "4", "--overwrite"}).exit_code, 0);
  EXPECT_EQ(cairn::base::read_file(fs::path(out_) / "costmap.tif"), one);
}

TEST_F(CostmapCommand, BadInputLeavesNothing) {
  cairn::base::write_file(obstacles_, "{\"obstacles\": [");
  const auto result = run();
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("obstacles.json"));
  EXPECT_FALSE(fs::exists(out_));
  obstacles_ = "none.json";
  EXPECT_EQ(run().exit_code, 4);
  EXPECT_EQ(cairn({"costmap", "-o", out_}).exit_code, 2);
}

}  // namespace
