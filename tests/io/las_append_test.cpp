#include "io/las_append.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "io/las.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::ScalarType;

const std::vector<LasAddition> kLabels = {{"label", ScalarType::u8, ""},
                                          {"target_id", ScalarType::u32, ""},
                                          {"probability", ScalarType::f32, "of the label"}};

void fill(std::uint64_t first, std::vector<std::vector<double>>& values) {
  for (std::size_t i = 0; i < values[0].size(); ++i) {
    values[0][i] = static_cast<double>((first + i) % 5);
    values[1][i] = 4294967295.0 - static_cast<double>(first + i);
    values[2][i] = 0.25;
  }
}

// Old and new formats, with and without extra bytes and records of their own.
TEST(LasAppend, KeepsEverythingElse) {
  for (const char* name : {"1.2-with-color.las", "autzen-utm.las", "extrabytes.las", "interesting.las", "utm15.las",
                           "lots_of_vlr.las", "sample_c_thin.las"}) {
    const auto path = testing::test_data("pdal_samples/las") / name;
    const testing::TempFolder folder;
    const auto before = read_las(path);
    append_las_dimensions(path, folder.path() / "out.las", kLabels, fill);
    const auto after = read_las(folder.path() / "out.las");
    ASSERT_EQ(after.cloud.size(), before.cloud.size()) << name;
    EXPECT_EQ(after.cloud.positions, before.cloud.positions) << name;
    EXPECT_EQ(after.cloud.colours, before.cloud.colours) << name;
    EXPECT_EQ(after.cloud.intensity, before.cloud.intensity) << name;
    EXPECT_EQ(after.cloud.gps_time, before.cloud.gps_time) << name;
    EXPECT_EQ(after.facts.crs, before.facts.crs) << name;
    EXPECT_EQ(after.metadata.point_format, before.metadata.point_format);
    EXPECT_EQ(after.metadata.records.size(), before.metadata.records.size());
    ASSERT_EQ(after.metadata.dimensions.size(), before.metadata.dimensions.size() + 3) << name;
    for (const auto& column : before.cloud.scalars) {
      ASSERT_NE(after.cloud.scalar(column.name), nullptr) << name;
      EXPECT_EQ(after.cloud.scalar(column.name)->values, column.values) << name << ' ' << column.name;
    }
    for (std::size_t i = 0; i < after.cloud.size(); ++i) {
      ASSERT_EQ(after.cloud.scalar("label")->values[i], static_cast<double>(i % 5));
      ASSERT_EQ(after.cloud.scalar("target_id")->values[i], 4294967295.0 - static_cast<double>(i));
      ASSERT_EQ(after.cloud.scalar("probability")->values[i], 0.25);
    }
    // Once more: the dimensions are overwritten, not doubled.
    append_las_dimensions(folder.path() / "out.las", folder.path() / "again.las", {{"label", ScalarType::u8, ""}},
                          [](std::uint64_t, std::vector<std::vector<double>>& v) { v[0].assign(v[0].size(), 9.0); });
    const auto again = read_las(folder.path() / "again.las");
    EXPECT_EQ(again.metadata.dimensions.size(), after.metadata.dimensions.size());
    EXPECT_EQ(again.cloud.scalar("label")->values.front(), 9.0);
    EXPECT_EQ(again.cloud.scalar("probability")->values, after.cloud.scalar("probability")->values);
  }
}

TEST(LasAppend, RefusesWhatDoesNotFit) {
  const auto path = testing::test_data("pdal_samples/las/utm15.las");
  const testing::TempFolder folder;
  const auto with = [&](double value, ScalarType type) {
    append_las_dimensions(path, folder.path() / "out.las", {{"label", type, ""}},
                          [value](std::uint64_t, std::vector<std::vector<double>>& v) { v[0][0] = value; });
  };
  EXPECT_NO_THROW(with(255.0, ScalarType::u8));
  EXPECT_THROW(with(256.0, ScalarType::u8), base::Error);
  EXPECT_THROW(with(-1.0, ScalarType::u32), base::Error);
  EXPECT_THROW(with(std::numeric_limits<double>::quiet_NaN(), ScalarType::f32), base::Error);
  with(1.0, ScalarType::u8);
  EXPECT_THROW(
      append_las_dimensions(folder.path() / "out.las", folder.path() / "b.las", {{"label", ScalarType::f32, ""}},
                            [](std::uint64_t, std::vector<std::vector<double>>&) {}),
      base::Error);
}

}  // namespace
}  // namespace cairn::io
