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

// The command as the manual writes it: prior map, layer of obstacles, scans along a log.
TEST_F(CostmapCommand, TakesPriorMapLayerScansAndLog) {
  cairn::io::RosMap prior;
  prior.occupancy = cairn::geometry::Grid<std::uint8_t>({0.0, 8.0, 0.05, 200, 160}, 0);
  const cairn::geodesy::LocalFrame frame(cairn::testing::kSmallGroundOrigin);
  cairn::io::write_ros_map(
      folder_.path(), "prior", prior,
      cairn::io::MapGeoreference{cairn::testing::kSmallGroundOrigin, cairn::survey::HeightType::ellipsoidal, "",
                                 frame.raster_crs_wkt()});
  cairn::base::write_file(
      folder_ / "layer.geojson",
      "{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"properties\":"
      "{\"width_m\":1.0},\"geometry\":{\"type\":\"Point\",\"coordinates\":[-91.9939344,46.842636]}}]}");
  cairn::base::write_file(
      folder_ / "lidar.csv",
      "time_ns,time_increment_ns,angle_min_deg,angle_increment_deg,range_min_m,range_max_m,ranges_m\n"
      "1000,0,0,90,0.1,30,2 inf -inf nan\n");
  cairn::base::write_file(folder_ / "vehicle.csv",
                          "time_ns,x_m,y_m,vx_m_s,vy_m_s,roll_deg,pitch_deg,heading_deg,var_xx_m2,var_xy_m2,var_yy_m2\n"
                          "0,7.02,2.02,0,0,0,0,90,,,\n2000,7.02,2.02,0,0,0,0,90,,,\n");
  const auto path = [&](const char* name) { return (folder_ / name).string(); };
  std::vector<std::string> arguments{"costmap",
                                     "--prior",
                                     path("prior.yaml"),
                                     "--obstacles",
                                     path("layer.geojson"),
                                     "--scans",
                                     path("lidar.csv"),
                                     "--vehicle",
                                     path("vehicle.csv"),
                                     "--radius",
                                     "0.4",
                                     "--resolution",
                                     "0.05",
                                     "-o",
                                     out_,
                                     "--json"};
  const auto result = cairn(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("radius_m").as_real(), 0.4);
  EXPECT_EQ(summary.at("obstacles_outside").as_integer(), 0);
  EXPECT_EQ(summary.at("scans").at("rays_marked").as_integer(), 1);
  EXPECT_EQ(summary.at("scans").at("rays_too_near").as_integer(), 1);
  const auto raster = cairn::io::read_raster(fs::path(out_) / "costmap.tif");
  const auto& cost = std::get<cairn::geometry::Grid<std::uint8_t>>(raster.bands.at(0).values);
  const auto value = [&](double e, double n) {
    const auto cell = cost.geometry.cell_at({e, n});
    return cost.at(cell->first, cell->second);
  };
  EXPECT_EQ(value(9.02, 2.02), cairn::ground::kLethal) << "heading east, 2 m ahead";
  EXPECT_EQ(value(9.35, 2.02), cairn::ground::kInscribed);
  EXPECT_EQ(value(5.0, 4.0), cairn::ground::kLethal) << "the obstacle of the layer";
  arguments.back() = "--dry-run";
  arguments[14] = (folder_ / "dry").string();
  EXPECT_EQ(cairn(arguments).exit_code, 0);
  arguments.back() = "--json";
  arguments[10] = "wide";
  EXPECT_EQ(cairn(arguments).exit_code, 2);
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
