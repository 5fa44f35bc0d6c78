#include "pipeline/layers_stage.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/csv.hpp"
#include "io/gaps_json.hpp"
#include "io/json.hpp"
#include "io/obstacles_json.hpp"
#include "io/rocks_json.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "io/vector.hpp"
#include "support/command.hpp"
#include "support/data.hpp"
#include "support/layer_records.hpp"

namespace cairn::pipeline {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// The example survey on disk.
class OnDisk {
 public:
  OnDisk() {
    const report::LayerRecords records = testing::example_records();
    survey::Survey survey;
    survey.manifest.name = "example";
    survey.manifest.origin = records.origin;
    survey.manifest.time_base = records.time_base;
    survey::Camera camera;
    camera.id = survey::CameraId(0);
    camera.width_px = 4000;
    camera.height_px = 3000;
    camera.fx_px = camera.fy_px = 2300.0;
    camera.cx_px = 2000.0;
    camera.cy_px = 1500.0;
    survey.manifest.cameras = {camera};
    survey.frames = records.frames;
    std::filesystem::create_directories(folder_ / "survey");
    io::write_survey(survey, folder_ / "survey");
    io::write_targets(folder_ / "targets.json", {records.origin, records.targets});
    io::write_rocks(folder_ / "rocks.json", {records.origin, records.rocks});
    io::write_obstacles(folder_ / "obstacles.json", {records.origin, records.obstacles});
    io::write_gaps(folder_ / "gaps.json", {records.origin, records.gaps});
  }

  [[nodiscard]] LayersInputs inputs() const {
    return {folder_ / "survey", folder_ / "targets.json", folder_ / "rocks.json", folder_ / "obstacles.json",
            folder_ / "gaps.json"};
  }
  [[nodiscard]] std::filesystem::path out(const std::string& name) const {
    std::filesystem::create_directories(folder_ / name);
    return folder_ / name;
  }
  [[nodiscard]] std::filesystem::path operator/(std::string_view name) const { return folder_ / name; }

 private:
  testing::TempFolder folder_;
};

TEST(LayersStage, WritesTheProducts) {
  const OnDisk disk;
  base::RunContext ctx;
  const auto out = disk.out("out");
  const Outcome outcome = layers_stage(disk.inputs(), out, {}, ctx);
  EXPECT_EQ(outcome.summary.at("features").at("footprints").as_integer(), 2);
  EXPECT_EQ(outcome.summary.at("inventory_rows").as_integer(), 3);
  // Median foot of the rocks that have a mesh.
  EXPECT_EQ(outcome.summary.at("ground_up_m").as_real(), -0.2);

  const auto layers = io::read_vector(out / "layers.gpkg");
  ASSERT_EQ(layers.size(), 6U);
  EXPECT_EQ(layers[4].name, "footprints");
  // 30.2 m above the ground, 4000 x 3000 px of 2300 px focal length.
  const double area = std::get<double>(layers[4].features[0].values[2]);
  EXPECT_NEAR(area, 30.2 / 2300.0 * 4000.0 * 30.2 / 2300.0 * 3000.0, 1e-6);

  io::CsvReader csv(out / "inventory.csv");
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.text(csv.column("name")), "boulder 4");
  EXPECT_EQ(csv.text(csv.column("density_assumed")), "true");
  EXPECT_NEAR(csv.real(csv.column("alpha_min_deg")), 30.0, 1e-9);
  ASSERT_TRUE(csv.next());
  EXPECT_EQ(csv.text(csv.column("alpha_min_deg")), "");
  EXPECT_EQ(io::read_json(out / "inventory.geojson").at("features").size(), 3U);
}

TEST(LayersStage, SameBytesEveryTime) {
  const OnDisk disk;
  base::RunContext ctx;
  (void)layers_stage(disk.inputs(), disk.out("a"), {}, ctx);
  (void)layers_stage(disk.inputs(), disk.out("b"), {}, ctx);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(disk / "a")) {
    ++files;
    EXPECT_EQ(base::read_file(entry.path()), base::read_file(disk / "b" / entry.path().filename())) << entry.path();
  }
  EXPECT_EQ(files, 4U);
}

TEST(LayersStage, GdalOpensEveryProductWithoutWarning) {
  const OnDisk disk;
  base::RunContext ctx;
  const auto out = disk.out("out");
  (void)layers_stage(disk.inputs(), out, {}, ctx);
  for (const char* name : {"layers.gpkg", "inventory.geojson", "inventory.kml", "inventory.csv"}) {
    const auto info = testing::run_command("ogrinfo -ro -al " + (out / name).string());
    EXPECT_EQ(info.exit_code, 0) << name;
    EXPECT_THAT(info.text, Not(HasSubstr("Warning"))) << name;
    EXPECT_THAT(info.text, Not(HasSubstr("ERROR"))) << name;
    EXPECT_THAT(info.text, HasSubstr("Feature Count: 3")) << name;
  }
  const auto styles = testing::run_command("ogrinfo -ro -q -sql \"SELECT f_table_name FROM layer_styles\" " +
                                           (out / "layers.gpkg").string());
  for (const char* name : {"targets", "rocks", "obstacles", "frames", "footprints", "gaps"})
    EXPECT_THAT(styles.text, HasSubstr(std::string("= ") + name));
}

TEST(LayersStage, WorksWithTheSurveyAlone) {
  const OnDisk disk;
  base::RunContext ctx;
  const Outcome outcome = layers_stage({disk.inputs().survey, {}, {}, {}, {}}, disk.out("out"), {}, ctx);
  EXPECT_EQ(outcome.summary.at("features").at("frames").as_integer(), 2);
  EXPECT_EQ(outcome.summary.at("features").at("footprints").as_integer(), 0);
  ASSERT_EQ(ctx.warnings().size(), 1U);
  EXPECT_THAT(ctx.warnings()[0], HasSubstr("No footprints"));
}

TEST(LayersStage, RefusesAnotherFrame) {
  const OnDisk disk;
  io::TargetsFile file = io::read_targets(disk / "targets.json");
  file.frame.position.latitude_deg += 1e-3;
  io::write_targets(disk / "targets.json", file);
  base::RunContext ctx;
  try {
    (void)layers_stage(disk.inputs(), disk.out("out"), {}, ctx);
    FAIL() << "no error";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::crs_mismatch);
    EXPECT_THAT(error.what(), HasSubstr("targets.json"));
  }
}

}  // namespace
}  // namespace cairn::pipeline
