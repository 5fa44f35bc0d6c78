#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/cloud.hpp"
#include "io/json.hpp"
#include "io/mesh.hpp"
#include "io/raster.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

using cairn::io::Json;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using cairn::testing::test_data;
using ::testing::HasSubstr;

Json info(const std::filesystem::path& path, int exit_code = 0) {
  const auto result = cairn({"info", path.string(), "--json"});
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  return exit_code == 0 ? cairn::io::parse_json(result.out, "stdout") : Json();
}

bool warns(const Json& json, const std::string& text) {
  for (const auto& warning : json.at("warnings").as_array())
    if (warning.as_string().find(text) != std::string::npos) return true;
  return false;
}

TEST(InfoCommand, DescribesLas) {
  const Json json = info(test_data("pdal_samples/las/utm17.las"));
  EXPECT_EQ(json.at("kind").as_string(), "cloud");
  EXPECT_EQ(json.at("format").as_string(), "LAS");
  EXPECT_EQ(json.at("version").as_string(), "1.2, point format 3");
  EXPECT_EQ(json.at("points").as_integer(), 10);
  EXPECT_EQ(json.at("crs").at("authority_code").as_string(), "EPSG:32617");
  EXPECT_EQ(json.at("stated_horizontal_unit_m").as_real(), 1.0);
  EXPECT_EQ(json.at("bounds").at("min").as_vec3().x(), 289814.15);
  EXPECT_EQ(json.at("scale").as_vec3().x(), 0.01);
}

TEST(InfoCommand, NamesExtraDimensionsAndMissingCrs) {
  const Json json = info(test_data("pdal_samples/las/extrabytes.las"));
  ASSERT_EQ(json.at("dimensions").size(), 7U);
  EXPECT_EQ(json.at("dimensions").as_array()[5].at("name").as_string(), "Intensity");
  EXPECT_TRUE(json.at("crs").is_null());
  EXPECT_TRUE(warns(json, "no coordinate reference system"));
}

TEST(InfoCommand, FindsAUnitThatContradictsTheCrs) {
  const TempFolder folder;
  std::string file = cairn::base::read_file(test_data("pdal_samples/las/utm17.las"));
  // ProjLinearUnitsGeoKey, 9001 -> 9003: metres become US survey feet.
  const std::string key("\x04\x0c\x00\x00\x01\x00\x29\x23", 8);
  const std::size_t at = file.find(key);
  ASSERT_NE(at, std::string::npos);
  file[at + 6] = '\x2b';
  cairn::base::write_file(folder / "feet.las", file);
  EXPECT_TRUE(warns(info(folder / "feet.las"), "nobody can tell"));
}

TEST(InfoCommand, DescribesMeshesWithTheirMass) {
  const Json box = info(test_data("pdal_samples/obj/box.obj"));
  EXPECT_EQ(box.at("kind").as_string(), "mesh");
  EXPECT_TRUE(box.at("topology").at("closed").as_bool());
  EXPECT_NEAR(box.at("volume_m3").as_real(), 1.0, 1e-12);  // unit cube, rounding
  const Json rock = info(test_data("polar_rocks/terrain01_rock6_decimate-005.obj"));
  EXPECT_TRUE(rock.at("volume_m3").is_null());
  EXPECT_TRUE(warns(rock, "not closed"));
  const TempFolder folder;
  cairn::io::write_mesh(folder / "a.glb", cairn::io::read_mesh(test_data("pdal_samples/obj/box.obj")).mesh);
  EXPECT_EQ(info(folder / "a.glb").at("format").as_string(), "GLB");
}

TEST(InfoCommand, OtherCloudFormats) {
  EXPECT_EQ(info(test_data("pdal_samples/ply/simple_text.ply")).at("kind").as_string(), "cloud");
  EXPECT_EQ(info(test_data("pdal_samples/ply/mesh.ply")).at("kind").as_string(), "mesh");
  EXPECT_EQ(info(test_data("pdal_samples/pcd/autzen-utm.pcd")).at("points").as_integer(), 1065);
  const TempFolder folder;
  cairn::base::write_file(folder / "a.csv", "x,y,z\n1,2,3\n");
  EXPECT_EQ(info(folder / "a.csv").at("format").as_string(), "XYZ");
}

TEST(InfoCommand, RastersLayersRunsAndJson) {
  const TempFolder folder;
  cairn::geometry::GridGeometry grid{500000.0, 4000010.0, 0.5, 30, 20};
  cairn::io::write_cog(
      folder / "a.tif",
      {{"height", "m", "height above a datum", cairn::geometry::Grid<float>(grid, 1.5F), std::nullopt}}, "EPSG:32615");
  const Json raster = info(folder / "a.tif");
  EXPECT_EQ(raster.at("kind").as_string(), "raster");
  EXPECT_EQ(raster.at("grid").at("columns").as_integer(), 30);
  EXPECT_EQ(raster.at("grid").at("south").as_real(), 4000000.0);
  EXPECT_EQ(raster.at("bands").as_array()[0].at("name").as_string(), "height");
  EXPECT_EQ(raster.at("crs").at("authority_code").as_string(), "EPSG:32615");

  cairn::base::write_file(folder / "a.json",
                          R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{"n":1},)"
                          R"("geometry":{"type":"Point","coordinates":[-92,46.8]}}]})");
  const Json layer = info(folder / "a.json");
  EXPECT_EQ(layer.at("kind").as_string(), "vector");
  EXPECT_EQ(layer.at("layers").as_array()[0].at("features").as_integer(), 1);

  std::filesystem::create_directory(folder / "run");
  cairn::base::write_file(folder / "run/run.json", R"({"command":"locate","inputs":[1,2]})");
  const Json run = info(folder / "run");
  EXPECT_EQ(run.at("kind").as_string(), "run");
  EXPECT_EQ(run.at("command").as_string(), "locate");
  EXPECT_EQ(run.at("files").size(), 1U);
  EXPECT_EQ(info(folder / "run/run.json").at("members").at("inputs").at("items").as_integer(), 2);
}

TEST(InfoCommand, AnEmptyCloudIsDescribed) {
  const TempFolder folder;
  cairn::io::write_cloud(folder / "a.las", {});
  const Json json = info(folder / "a.las");
  EXPECT_EQ(json.at("points").as_integer(), 0);
  EXPECT_TRUE(json.at("bounds").is_null());
}

TEST(InfoCommand, RefusesWithThePlaceAndExitCode4) {
  const TempFolder folder;
  const std::string file = cairn::base::read_file(test_data("pdal_samples/las/utm17.las"));
  cairn::base::write_file(folder / "cut.las", file.substr(0, 500));
  cairn::base::write_file(folder / "a.bin", "what is this");
  cairn::base::write_file(folder / "empty.las", "");
  for (const char* name : {"cut.las", "a.bin", "empty.las", "absent.las"}) {
    const auto result = cairn({"info", (folder / name).string()});
    EXPECT_EQ(result.exit_code, 4) << name;
    EXPECT_THAT(result.err, HasSubstr(name));
    EXPECT_EQ(result.out, "");
  }
  EXPECT_THAT(cairn({"info", (folder / "cut.las").string()}).err, HasSubstr("byte 107"));
  EXPECT_EQ(cairn({"info", folder.path().string()}).exit_code, 4);
}

TEST(InfoCommand, PlainTextForPeople) {
  const auto result = cairn({"info", test_data("pdal_samples/las/utm17.las").string()});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("points: 10\n"));
  EXPECT_THAT(result.out, HasSubstr("  name: WGS 84 / UTM zone 17N\n"));
}

}  // namespace
