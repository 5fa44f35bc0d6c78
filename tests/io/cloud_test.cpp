#include "io/cloud.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/xyz.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::Vec3;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Cloud, EveryFormatBringsTheSamePointsBack) {
  constexpr double kLasStep = 0.5e-4 + 1e-9;  // half a step of the chosen scale
  const testing::TempFolder folder;
  geometry::PointCloud cloud;
  cloud.positions = {{576661.9712, 5188114.0634, 156.0671}, {576662.0749, 5188114.1565, 156.0778}};
  cloud.colours = {{0, 257, 65535}, {257, 514, 771}};
  cloud.intensity = {3, 400};
  cloud.classification = {2, 6};
  cloud.add_scalar("target_id", geometry::ScalarType::u32, "").values = {0, 70000};
  CloudWriteOptions options;
  options.crs = "EPSG:32615";
  for (const char* name : {"a.las", "a.ply", "a.pcd", "a.csv"}) {
    write_cloud(folder / name, cloud, options);
    const CloudFile back = read_cloud(folder / name);
    ASSERT_EQ(back.cloud.size(), 2U) << name;
    for (std::size_t i = 0; i < 2; ++i)
      EXPECT_LE((back.cloud.positions[i] - cloud.positions[i]).cwiseAbs().maxCoeff(), kLasStep) << name;
    EXPECT_EQ(back.cloud.colours, cloud.colours) << name;
    EXPECT_EQ(back.cloud.intensity, cloud.intensity) << name;
    EXPECT_EQ(back.cloud.classification, cloud.classification) << name;
    ASSERT_NE(back.cloud.scalar("target_id"), nullptr) << name;
    EXPECT_EQ(back.cloud.scalar("target_id")->values, cloud.scalars[0].values) << name;
    EXPECT_EQ(back.las.has_value(), std::string_view(name) == "a.las");
  }
  EXPECT_EQ(read_cloud(folder / "a.las").facts.crs, "EPSG:32615");
  EXPECT_EQ(read_cloud(folder / "a.ply").facts.crs, "EPSG:32615");
  EXPECT_THROW(write_cloud(folder / "a.laz", cloud), base::Error);
}

TEST(Cloud, RecognisesByContentBeforeExtension) {
  const testing::TempFolder folder;
  std::filesystem::copy_file(testing::test_data("pdal_samples/las/utm17.las"), folder / "a.ply");
  EXPECT_EQ(recognise_cloud(folder / "a.ply"), CloudFormat::las);
  base::write_file(folder / "points", "# east north up\n1 2 3\n4 5 6\n");
  EXPECT_EQ(recognise_cloud(folder / "points"), CloudFormat::xyz);
  base::write_file(folder / "a.e57", "ASTM-E57 and more");
  base::write_file(folder / "empty.las", "");
  base::write_file(folder / "a.las", "no magic");
  base::write_file(folder / "a.bin", std::string("\0\1\2\3", 4));
  for (const char* name : {"a.e57", "empty.las", "a.las", "a.bin"}) {
    try {
      (void)read_cloud(folder / name);
      FAIL() << name;
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), base::ErrorCode::invalid_input) << name;
      EXPECT_EQ(error.file(), (folder / name).string());
    }
  }
}

CloudData parse(const std::string& content) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.xyz", content);
  return read_xyz(folder / "a.xyz");
}

TEST(Xyz, SniffsSeparatorsAndNames) {
  EXPECT_THAT(parse("1 2 3\n4\t5  6\n").cloud.positions, ElementsAre(Vec3(1, 2, 3), Vec3(4, 5, 6)));
  EXPECT_THAT(parse("1;2;3;\n4;5;6;\n").cloud.positions, ElementsAre(Vec3(1, 2, 3), Vec3(4, 5, 6)));
  const CloudData csv = parse("\xEF\xBB\xBF\"Elevation\",Northing,Easting,hag\r\n3,2,1,0.5\r\n");
  EXPECT_THAT(csv.cloud.positions, ElementsAre(Vec3(1, 2, 3)));
  EXPECT_EQ(csv.cloud.scalar("hag")->values[0], 0.5);
  const CloudData compare = parse("//X Y Z R G B Nx Ny Nz\n1 2 3 255 0 128 0 0 2\n");
  EXPECT_THAT(compare.cloud.colours[0], ElementsAre(65535, 0, 128 * 257));
  EXPECT_EQ(compare.cloud.normals[0], Vec3(0, 0, 1));
  EXPECT_EQ(parse("1 2 3 4\n").cloud.scalar("column_4")->values[0], 4.0);
  EXPECT_EQ(parse("5188114.06123456789 576661.97123456789 1\n").cloud.positions[0].x(), 5188114.06123456789);
  EXPECT_TRUE(parse("x,y,z\n").cloud.empty());
}

TEST(Xyz, BadInputIsNamedByLine) {
  const auto refused = [](const std::string& content, const std::string& record, const std::string& message) {
    try {
      (void)parse(content);
      FAIL() << "accepted: " << content;
    } catch (const base::Error& error) {
      EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
      EXPECT_EQ(error.record(), record);
      EXPECT_THAT(error.what(), HasSubstr(message));
    }
  };
  refused("1 2 3\n4 5\n", "line 2", "another number of columns");
  refused("1,2,3\n4,5,x\n", "line 2", "not a number");
  refused("1,5 2,5 3,5\n\n", "line 1", "neither numbers nor names");  // decimal commas
  refused("a b c\n", "line 1", "neither numbers nor names");
  refused("1 2\n", "line 1", "not a table of points");
  refused("# nothing\n", "line 1", "no points");
}

TEST(Xyz, DropsWhatIsNotFinite) {
  const CloudData data = parse("1 2 3\nnan 2 3\n1 2 -inf\n");
  EXPECT_EQ(data.cloud.size(), 1U);
  EXPECT_EQ(data.facts.dropped_points, 2U);
}

}  // namespace
}  // namespace cairn::io
