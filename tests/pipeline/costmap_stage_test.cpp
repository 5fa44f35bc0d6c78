#include "pipeline/costmap_stage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/range_scans.hpp"
#include "io/raster.hpp"
#include "io/ros_map.hpp"
#include "io/vector.hpp"
#include "io/vehicle_csv.hpp"
#include "support/data.hpp"
#include "support/small_ground.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;
using geometry::Grid;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TempFolder;
constexpr std::uint8_t kNotKnown = 255;

// A prior map of 10 m x 8 m: a wall of 0.2 m along the north, unknown ground in the south-western 1 m x 1 m.
io::RosMap prior_map(double cell = 0.05) {
  io::RosMap map;
  const auto columns = static_cast<std::size_t>(std::lround(10.0 / cell)),
             rows = static_cast<std::size_t>(std::lround(8.0 / cell));
  map.occupancy = Grid<std::uint8_t>({0.0, 8.0, cell, columns, rows}, 0);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c) {
      const auto p = map.occupancy.geometry.centre(r, c);
      if (p.y() > 7.8) map.occupancy.at(r, c) = 100;
      if (p.x() < 1.0 && p.y() < 1.0) map.occupancy.at(r, c) = io::kOccupancyUnknown;
    }
  return map;
}

class CostmapStage : public ::testing::Test {
 protected:
  TempFolder folder_;
  CostmapInputs in_;
  CostmapStageOptions options_;
  base::RunContext ctx_;

  void SetUp() override {
    testing::write_small_ground(folder_.path());
    write_prior(prior_map());
    in_.prior = folder_ / "prior.yaml";
  }
  void write_prior(const io::RosMap& map) {
    const geodesy::LocalFrame frame(testing::kSmallGroundOrigin);
    io::write_ros_map(
        folder_.path(), "prior", map,
        io::MapGeoreference{testing::kSmallGroundOrigin, survey::HeightType::ellipsoidal, "", frame.raster_crs_wkt()});
  }
  // A GeoPackage as `cairn obstacles` writes it: points on WGS84.
  void write_layers(const std::vector<std::pair<geometry::Vec2, std::string>>& places) {
    const geodesy::LocalFrame frame(testing::kSmallGroundOrigin);
    io::Layer layer;
    layer.name = "obstacles";
    layer.title = "test";
    layer.columns = {{"kind", io::ColumnType::text, "", "kind"}, {"width_m", io::ColumnType::real, "m", "width"}};
    for (const auto& [p, kind] : places) {
      io::Feature feature;
      feature.parts = {{{frame.to_geodetic({p.x(), p.y(), 1.0})}}};
      feature.values = {kind, 1.0};
      layer.features.push_back(feature);
    }
    io::write_geopackage(folder_ / "layers.gpkg", {layer});
  }
  fs::path run(const std::string& name = "out") {
    const fs::path out = folder_ / name;
    fs::create_directory(out);
    outcome_ = costmap_stage(in_, out, options_, ctx_);
    return out;
  }
  std::string error_of(base::ErrorCode code) {
    try {
      (void)run("failed");
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      fs::remove_all(folder_ / "failed");
      return error.what();
    }
    fs::remove_all(folder_ / "failed");
    return "no error";
  }
  static std::uint8_t value(const fs::path& out, const std::string& band, double east, double north) {
    const io::Raster raster = io::read_raster(out / "costmap.tif");
    for (const auto& b : raster.bands)
      if (b.name == band) {
        const auto& grid = std::get<Grid<std::uint8_t>>(b.values);
        const auto cell = grid.geometry.cell_at({east, north});
        return grid.at(cell->first, cell->second);
      }
    ADD_FAILURE() << "no band " << band;
    return 0;
  }
  Outcome outcome_;
};

TEST_F(CostmapStage, PriorMapAndObstaclesOfAGeoPackage) {
  write_layers({{{5.0, 4.0}, "obstacle"}, {{2.0, 2.0}, "ignored"}, {{40.0, 4.0}, "obstacle"}});
  in_.obstacles = folder_ / "layers.gpkg";
  const fs::path out = run();
  EXPECT_EQ(value(out, "cost", 5.01, 4.01), ground::kLethal);
  EXPECT_EQ(value(out, "cost", 5.7, 4.01), ground::kInscribed);
  EXPECT_EQ(value(out, "cost", 5.0, 7.9), ground::kLethal);
  EXPECT_EQ(value(out, "cost", 2.0, 2.0), 0);
  EXPECT_EQ(value(out, "cost", 0.5, 0.5), ground::kUnknown);
  EXPECT_EQ(value(out, "prior", 5.0, 7.9), 100);
  EXPECT_EQ(value(out, "obstacles", 5.0, 7.9), kNotKnown);
  EXPECT_EQ(value(out, "obstacles", 5.01, 4.01), 100);
  ASSERT_EQ(outcome_.rejects.size(), 1U);
  EXPECT_EQ(outcome_.rejects[0].reason, "outside_map");
  EXPECT_EQ(outcome_.summary.at("obstacles").as_integer(), 3);
  for (const char* file : {"map.pgm", "map.yaml", "map.georeference.json", "keepout.pgm", "keepout.yaml",
                           "keepout.georeference.json", "keepout_params.yaml"})
    EXPECT_TRUE(fs::exists(out / file)) << file;
  const io::RosMap map = io::read_ros_map(out / "map.yaml");
  EXPECT_EQ(map.occupancy.geometry, prior_map().occupancy.geometry);
}

TEST_F(CostmapStage, StripsGiveTheSameBytes) {
  in_.obstacles = folder_ / "obstacles.json";
  in_.surface = folder_ / "surface.tif";
  options_.keepout_inflate_m = 0.3;
  const fs::path whole = run("whole");
  for (const int rows : {7, 64}) {
    options_.strip_rows = rows;
    const fs::path strips = run("strips" + std::to_string(rows));
    for (const char* file : {"costmap.tif", "map.pgm", "keepout.pgm", "map.yaml"})
      EXPECT_EQ(base::read_file(strips / file), base::read_file(whole / file)) << file << " " << rows;
  }
}

TEST_F(CostmapStage, ScansMarkAndClear) {
  // A vehicle that stands at (3, 4) and faces east: a wall at x = 6 in the south-eastern quarter, nothing elsewhere.
  std::vector<survey::VehicleState> log(3);
  for (std::size_t i = 0; i < 3; ++i) {
    log[i].time_ns = static_cast<std::int64_t>(i) * 100'000'000;
    log[i].position = {3.02, 4.02};
  }
  io::write_vehicle_csv(folder_ / "vehicle.csv", log);
  survey::RangeScan scan;
  scan.time_ns = 50'000'000;
  scan.angle_min = -std::numbers::pi;
  scan.angle_increment = 0.005;
  scan.range_min_m = 0.1;
  scan.range_max_m = 30.0;
  for (int i = 0; i < 1256; ++i) {
    const double angle = scan.angle_min + i * scan.angle_increment;
    const bool wall = angle > -0.7 && angle < 0.0;
    scan.ranges.push_back(wall ? static_cast<float>(3.0 / std::cos(angle)) : std::numeric_limits<float>::infinity());
  }
  auto late = scan;
  late.time_ns = 900'000'000;
  io::write_range_scans(folder_ / "lidar.csv", std::vector{scan, late});
  in_.scans = folder_ / "lidar.csv";
  in_.vehicle = folder_ / "vehicle.csv";
  const fs::path out = run();
  EXPECT_EQ(value(out, "scans", 6.02, 3.5), 100);
  EXPECT_EQ(value(out, "scans", 4.5, 3.5), 0);
  EXPECT_EQ(value(out, "scans", 6.5, 3.7), kNotKnown) << "behind the wall";
  EXPECT_EQ(value(out, "cost", 6.02, 3.5), ground::kLethal);
  EXPECT_EQ(value(out, "cost", 0.7, 0.8), 0) << "the scanner saw through what the prior map did not know";
  EXPECT_EQ(value(out, "occupancy", 3.0, 7.9), 100) << "a scan does not take away a wall of the prior map";
  ASSERT_EQ(outcome_.rejects.size(), 1U);
  EXPECT_EQ(outcome_.rejects[0].reason, "outside_log");
  EXPECT_EQ(outcome_.summary.at("scans").at("used").as_integer(), 1);
  options_.combine.scans_clear_prior = true;
  EXPECT_EQ(value(run("cleared"), "occupancy", 3.0, 7.9), 0);

  // Another time base: no scan has a pose.
  for (auto& state : log) state.time_ns += 1'700'000'000'000'000'000;
  io::write_vehicle_csv(folder_ / "vehicle.csv", log);
  EXPECT_THAT(error_of(base::ErrorCode::failed_precondition), HasSubstr("time base"));
  in_.vehicle.clear();
  EXPECT_THAT(error_of(base::ErrorCode::invalid_argument), HasSubstr("--vehicle"));
}

TEST_F(CostmapStage, LeaningVehiclesAndGapsOfTheLog) {
  std::vector<survey::VehicleState> log(4);
  const std::int64_t times[] = {0, 100'000'000, 5'000'000'000, 5'100'000'000};
  for (std::size_t i = 0; i < 4; ++i) {
    log[i].time_ns = times[i];
    log[i].position = {5.0, 4.0};
  }
  log[3].pitch = 0.3;
  io::write_vehicle_csv(folder_ / "vehicle.csv", log);
  std::vector<survey::RangeScan> scans(3);
  const std::int64_t scan_times[] = {50'000'000, 2'000'000'000, 5'050'000'000};
  for (std::size_t i = 0; i < 3; ++i) {
    scans[i].time_ns = scan_times[i];
    scans[i].angle_increment = 0.1;
    scans[i].range_max_m = 30.0;
    scans[i].ranges = {2.0F};
  }
  io::write_range_scans(folder_ / "lidar.csv", scans);
  in_.scans = folder_ / "lidar.csv";
  in_.vehicle = folder_ / "vehicle.csv";
  (void)run();
  ASSERT_EQ(outcome_.rejects.size(), 2U);
  EXPECT_EQ(outcome_.rejects[0].reason, "log_gap");
  EXPECT_EQ(outcome_.rejects[1].reason, "tilted");
}

TEST_F(CostmapStage, PriorOfAnotherResolutionIsResampledWithoutLoss) {
  write_prior(prior_map(0.2));
  const fs::path out = run();
  EXPECT_THAT(ctx_.warnings(), ElementsAre(HasSubstr("0.2 m cells is resampled to 0.05 m")));
  EXPECT_EQ(value(out, "prior", 5.0, 7.81), 100);
  EXPECT_EQ(value(out, "prior", 5.0, 7.79), 0);
  EXPECT_EQ(value(out, "prior", 0.5, 0.5), kNotKnown);
  options_.cost.resolution_m = 0.3;
  EXPECT_EQ(value(run("coarse"), "prior", 5.0, 7.75), 100) << "a cell that holds some of the wall";
}

TEST_F(CostmapStage, TurnedPriorIsRefusedUnlessDeclared) {
  in_.prior = testing::test_data("nav2_maps/testmap.yaml");
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input), HasSubstr("yaw 1"));
  options_.accept_yaw = true;
  const fs::path out = run();
  EXPECT_EQ(outcome_.summary.at("georeferenced").as_bool(), false);
  EXPECT_FALSE(fs::exists(out / "map.georeference.json"));
  // The map's lower left corner stands at (2, 3); half a metre along its turned diagonal lies inside.
  const double along = 1.0 + 0.25 * std::numbers::pi;
  // Such a map is a prior map again.
  in_.prior = out / "costmap.tif";
  EXPECT_EQ(base::read_file(run("again") / "map.pgm"), base::read_file(out / "map.pgm"));
  EXPECT_NE(value(out, "prior", 2.0 + 0.7 * std::cos(along), 3.0 + 0.7 * std::sin(along)), kNotKnown);
  EXPECT_EQ(value(out, "prior", 2.5, 3.1), kNotKnown) << "outside the turned map";
}

TEST_F(CostmapStage, OtherFramesAreErrors) {
  // A GeoTIFF in UTM beside obstacles of a local frame.
  io::write_cog(folder_ / "utm.tif",
                {{"occupancy", "", "", Grid<std::uint8_t>({576000.0, 5188000.0, 0.05, 60, 60}, 0), 255}}, "EPSG:32615");
  in_.prior = folder_ / "utm.tif";
  in_.obstacles = folder_ / "obstacles.json";
  EXPECT_THAT(error_of(base::ErrorCode::crs_mismatch), HasSubstr("different frames"));
  // Alone, or with positions on WGS84, it is a map like any other.
  const geodesy::LocalFrame frame(testing::kSmallGroundOrigin);
  write_layers({{{0.0, 0.0}, "obstacle"}});
  in_.obstacles = folder_ / "layers.gpkg";
  (void)run("utm");
  EXPECT_EQ(outcome_.summary.at("obstacles_outside").as_integer(), 1);
  // Degrees are no metres.
  io::write_cog(folder_ / "degrees.tif",
                {{"occupancy", "", "", Grid<std::uint8_t>({-92.0, 46.9, 0.01, 10, 10}, 0), 255}}, "EPSG:4326");
  in_.prior = folder_ / "degrees.tif";
  EXPECT_THAT(error_of(base::ErrorCode::crs_mismatch), HasSubstr("not metres"));
  // A map without place and a layer with one.
  fs::remove(folder_ / "prior.georeference.json");
  in_.prior = folder_ / "prior.yaml";
  EXPECT_THAT(error_of(base::ErrorCode::crs_mismatch), HasSubstr("--survey"));
}

TEST_F(CostmapStage, PolygonsOfAPriorMap) {
  const geodesy::LocalFrame frame(testing::kSmallGroundOrigin);
  io::Layer layer;
  layer.name = "park";
  layer.title = "test";
  layer.kind = io::GeometryKind::polygon;
  layer.with_heights = false;
  layer.columns = {{"occupancy", io::ColumnType::text, "", "blocked or free"}};
  const auto add = [&](const geometry::Ring& ring, const std::string& occupancy) {
    io::Feature feature;
    feature.parts = {{io::to_geodetic(frame, ring, 0.0)}};
    feature.values = {occupancy};
    layer.features.push_back(feature);
  };
  add({{0, 0}, {4, 0}, {4, 4}, {0, 4}}, "blocked");
  io::write_geopackage(folder_ / "blocked.gpkg", {layer});
  in_.prior = folder_ / "blocked.gpkg";
  in_.obstacles = folder_ / "obstacles.json";
  options_.extent = "-1,-1,9,9";
  const fs::path blocked = run("blocked");
  EXPECT_EQ(value(blocked, "prior", 2.0, 2.0), 100);
  EXPECT_EQ(value(blocked, "prior", 8.0, 8.0), 0);
  EXPECT_EQ(value(blocked, "cost", 5.01, 4.01), ground::kLethal);
  add({{-1, -1}, {6, -1}, {6, 6}, {-1, 6}}, "free");
  io::write_geopackage(folder_ / "roads.gpkg", {layer});
  in_.prior = folder_ / "roads.gpkg";
  const fs::path roads = run("roads");
  EXPECT_EQ(value(roads, "prior", 2.0, 2.0), 100) << "what blocks wins";
  EXPECT_EQ(value(roads, "prior", 5.0, 5.0), 0);
  EXPECT_EQ(value(roads, "prior", 8.0, 8.0), kNotKnown);
  options_.outside = "occupied";
  EXPECT_EQ(value(run("walled"), "prior", 8.0, 8.0), 100);
  add({{0, 0}, {1, 0}, {1, 1}}, "perhaps");
  io::write_geopackage(folder_ / "odd.gpkg", {layer});
  in_.prior = folder_ / "odd.gpkg";
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input), HasSubstr("perhaps"));
}

TEST_F(CostmapStage, MapModesAndKeepout) {
  in_.obstacles = folder_ / "obstacles.json";
  options_.map_mode = "raw";
  options_.keepout_inflate_m = 0.5;
  const fs::path raw = run("raw");
  const io::RosMap map = io::read_ros_map(raw / "map.yaml");
  const auto at = [](const io::RosMap& m, double east, double north) {
    const auto cell = m.occupancy.geometry.cell_at({east, north});
    return static_cast<int>(m.occupancy.at(cell->first, cell->second));
  };
  EXPECT_EQ(map.mode, io::MapMode::raw);
  EXPECT_EQ(at(map, 5.01, 4.01), 100);
  EXPECT_EQ(at(map, 5.7, 4.01), 99);
  EXPECT_GT(at(map, 6.2, 4.01), 5);
  EXPECT_LT(at(map, 6.2, 4.01), 60);
  EXPECT_EQ(at(map, 0.5, 0.5), io::kOccupancyUnknown);
  // Every cost, as Nav2's costmap publisher would put it.
  const io::Raster raster = io::read_raster(raw / "costmap.tif");
  const auto& cost = std::get<Grid<std::uint8_t>>(raster.bands.at(0).values);
  std::vector<int> seen(256, 0);
  for (std::size_t i = 0; i < cost.values.size(); ++i) {
    const int c = cost.values[i];
    const int expected = c == 255 ? 255 : c == 254 ? 100 : c == 253 ? 99 : c == 0 ? 0 : 1 + 97 * (c - 1) / 251;
    ASSERT_EQ(static_cast<int>(map.occupancy.values[i]), expected) << "cost " << c;
    seen[static_cast<std::size_t>(c)] = 1;
  }
  EXPECT_GT(std::count(seen.begin(), seen.end(), 1), 100) << "many costs occur";
  const io::RosMap keepout = io::read_ros_map(raw / "keepout.yaml");
  EXPECT_EQ(at(keepout, 5.95, 4.01), 100) << "0.5 m about a boulder of 1 m";
  EXPECT_EQ(at(keepout, 6.1, 4.01), 0);
  EXPECT_EQ(at(keepout, 0.5, 0.5), io::kOccupancyUnknown);
  options_.map_mode = "scale";
  const io::RosMap scale = io::read_ros_map(run("scale") / "map.yaml");
  EXPECT_EQ(scale.mode, io::MapMode::scale);
  EXPECT_EQ(scale.occupancy.values, map.occupancy.values);
}

TEST_F(CostmapStage, TerrainThatCannotBeDriven) {
  Grid<float> heights({0.0, 8.0, 0.25, 40, 32}, 1.0F);
  for (std::size_t r = 0; r < 32; ++r)
    for (std::size_t c = 30; c < 40; ++c) heights.at(r, c) = 2.0F;
  const geodesy::LocalFrame frame(testing::kSmallGroundOrigin);
  io::write_cog(folder_ / "step.tif", {{"ground", "m", "", heights, {}}}, frame.raster_crs_wkt());
  in_.prior.clear();
  in_.surface = folder_ / "step.tif";
  options_.terrain_layers = true;
  const fs::path out = run();
  EXPECT_EQ(value(out, "terrain", 7.45, 4.0), 100);
  EXPECT_EQ(value(out, "terrain", 3.0, 4.0), 0);
  EXPECT_EQ(value(out, "cost", 7.45, 4.0), ground::kLethal);
  const io::Raster terrain = io::read_raster(out / "terrain.tif");
  ASSERT_EQ(terrain.bands.size(), 4U);
  EXPECT_EQ(terrain.bands[3].name, "traversability");
  in_.surface.clear();
  EXPECT_THAT(error_of(base::ErrorCode::invalid_argument), HasSubstr("--surface"));
}

TEST_F(CostmapStage, ExtentsAndMissingSources) {
  in_.prior.clear();
  EXPECT_THAT(error_of(base::ErrorCode::invalid_argument), HasSubstr("--extent"));
  for (const char* text : {"1,2,3", "0,0,0,1", "a,b,c,d", "0,0,1,1,1", "0,0,nan,1"}) {
    options_.extent = text;
    EXPECT_THAT(error_of(base::ErrorCode::invalid_argument), HasSubstr("--extent")) << text;
  }
  options_.extent = "4,3,6,5";
  in_.obstacles = folder_ / "obstacles.json";
  EXPECT_EQ(value(run("unknown"), "cost", 4.1, 3.1), ground::kUnknown);
  options_.outside = "free";
  const fs::path out = run("free");
  EXPECT_EQ(value(out, "cost", 5.01, 4.01), ground::kLethal);
  EXPECT_LT(value(out, "cost", 4.1, 3.1), ground::kInscribed);
  in_.prior = folder_ / "prior.txt";
  base::write_file(in_.prior, "x");
  EXPECT_THAT(error_of(base::ErrorCode::invalid_input), HasSubstr("unknown kind"));
}

}  // namespace
}  // namespace cairn::pipeline
