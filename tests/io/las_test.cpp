#include "io/las.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::PointCloud;
using geometry::ScalarType;
using geometry::Vec3;
using ::testing::HasSubstr;

// A coordinate is rounded to the nearest step; the product and sum that give it back round again.
constexpr double kHalfStep = 0.5 + 1e-6;

std::filesystem::path pdal(std::string_view name) {
  return testing::test_data("pdal_samples/las") / name;
}

template <typename T>
T at(const std::string& file, std::size_t offset) {
  T value;
  std::memcpy(&value, file.data() + offset, sizeof(T));
  return value;
}

PointCloud utm_cloud() {
  PointCloud cloud;
  for (int i = 0; i < 1000; ++i) {
    cloud.positions.emplace_back(576661.9712 + 0.1037 * i, 5188114.0634 + 0.0931 * i, 156.0671 + 0.0107 * i);
    cloud.intensity.push_back(static_cast<std::uint16_t>(60 * i));
    cloud.classification.push_back(static_cast<std::uint8_t>(i % 20));
    cloud.colours.push_back({static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(65535 - i), 300});
    cloud.gps_time.push_back(284371.5 + 0.25 * i);
  }
  auto& id = cloud.add_scalar("target_id", ScalarType::u32, "instance");
  for (std::size_t i = 0; i < cloud.size(); ++i) id.values[i] = 4'000'000'000.0 - static_cast<double>(i);
  auto& height = cloud.add_scalar("hag", ScalarType::f32, "height above ground [m]");
  for (std::size_t i = 0; i < cloud.size(); ++i) height.values[i] = 0.25 * static_cast<double>(i);
  return cloud;
}

void expect_within_half_step(const PointCloud& found, const PointCloud& wanted, const Vec3& scale) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      ASSERT_LE(std::abs(found.positions[i][axis] - wanted.positions[i][axis]), kHalfStep * scale[axis]) << i;
}

TEST(LasWrite, Las14ComesBackWithinHalfAStep) {
  const testing::TempFolder folder;
  const PointCloud cloud = utm_cloud();
  LasWriteOptions options;
  options.crs_wkt = "PROJCS[\"WGS 84 / UTM zone 15N\",...]";
  options.crs = "EPSG:32615";
  write_las(folder / "a.las", cloud, options);
  const LasCloud back = read_las(folder / "a.las");
  EXPECT_EQ(back.metadata.minor_version, 4);
  EXPECT_EQ(back.metadata.point_format, 7);
  EXPECT_EQ(back.metadata.crs, options.crs_wkt);
  EXPECT_EQ(back.metadata.scale, Vec3::Constant(1e-4));
  EXPECT_TRUE(back.facts.warnings.empty()) << back.facts.warnings.front();
  expect_within_half_step(back.cloud, cloud, back.metadata.scale);
  EXPECT_EQ(back.cloud.intensity, cloud.intensity);
  EXPECT_EQ(back.cloud.classification, cloud.classification);
  EXPECT_EQ(back.cloud.colours, cloud.colours);
  EXPECT_EQ(back.cloud.gps_time, cloud.gps_time);
  ASSERT_EQ(back.cloud.scalars.size(), 2U);
  EXPECT_EQ(back.cloud.scalars[0].name, "target_id");
  EXPECT_EQ(back.cloud.scalars[0].type, ScalarType::u32);
  EXPECT_EQ(back.cloud.scalars[0].values, cloud.scalars[0].values);
  EXPECT_EQ(back.cloud.scalars[1].description, "height above ground [m]");
  EXPECT_EQ(back.cloud.scalars[1].values, cloud.scalars[1].values);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(std::abs(back.metadata.bounds.min[axis] - cloud.positions.front()[axis]), 1e-4);
    EXPECT_LE(std::abs(back.metadata.bounds.max[axis] - cloud.positions.back()[axis]), 1e-4);
  }
}

// LAS 1.4-R16, table 3: the offsets of the public header block, read without our reader.
TEST(LasWrite, HeaderBytesStandWhereTheSpecificationPutsThem) {
  const testing::TempFolder folder;
  LasWriteOptions options;
  options.crs_wkt = "PROJCS[\"x\"]";
  options.crs = "EPSG:32615";
  write_las(folder / "a.las", utm_cloud(), options);
  const std::string file = base::read_file(folder / "a.las");
  EXPECT_EQ(file.substr(0, 4), "LASF");
  EXPECT_EQ(at<std::uint16_t>(file, 6), 16);  // WKT
  EXPECT_EQ(at<std::uint8_t>(file, 24), 1);
  EXPECT_EQ(at<std::uint8_t>(file, 25), 4);
  EXPECT_EQ(at<std::uint16_t>(file, 94), 375);
  const std::size_t wkt = 54 + options.crs_wkt.size() + 1, extra = 54 + 2 * 192;
  EXPECT_EQ(at<std::uint32_t>(file, 96), 375 + wkt + extra);
  EXPECT_EQ(at<std::uint32_t>(file, 100), 2U);
  EXPECT_EQ(at<std::uint8_t>(file, 104), 7);
  EXPECT_EQ(at<std::uint16_t>(file, 105), 36 + 4 + 4);
  EXPECT_EQ(at<std::uint32_t>(file, 107), 0U);  // legacy count
  EXPECT_EQ(at<double>(file, 131), 1e-4);
  EXPECT_EQ(at<double>(file, 155), std::round(at<double>(file, 155)));  // whole offset
  EXPECT_GT(at<double>(file, 179), at<double>(file, 187));              // max x before min x
  EXPECT_EQ(at<std::uint64_t>(file, 235), 0U);
  EXPECT_EQ(at<std::uint64_t>(file, 247), 1000U);
  EXPECT_EQ(at<std::uint64_t>(file, 255), 1000U);  // all first returns
  EXPECT_EQ(file.size(), at<std::uint32_t>(file, 96) + 1000U * 44U);
  EXPECT_EQ(std::string(file.c_str() + 375 + 2), "LASF_Projection");
  EXPECT_EQ(at<std::uint16_t>(file, 375 + 18), 2112);
  // First point: raw x gives back the coordinate.
  const std::size_t first = at<std::uint32_t>(file, 96);
  EXPECT_NEAR(at<std::int32_t>(file, first) * 1e-4 + at<double>(file, 155), 576661.9712, 0.5e-4 + 1e-9);
  EXPECT_EQ(at<std::uint8_t>(file, first + 14), 0x11);  // return 1 of 1
}

TEST(LasWrite, Las12KeepsFormatsAndGeoKeys) {
  const testing::TempFolder folder;
  struct Case {
    bool time, colour;
    int format;
  };
  for (const Case c : {Case{false, false, 0}, Case{true, false, 1}, Case{false, true, 2}, Case{true, true, 3}}) {
    PointCloud cloud = utm_cloud();
    if (!c.time) cloud.gps_time.clear();
    if (!c.colour) cloud.colours.clear();
    LasWriteOptions options;
    options.minor_version = 2;
    options.crs = "EPSG:32615+5773";
    options.scale = Vec3::Constant(0.01);
    write_las(folder / "a.las", cloud, options);
    const LasCloud back = read_las(folder / "a.las");
    EXPECT_EQ(back.metadata.minor_version, 2);
    EXPECT_EQ(back.metadata.point_format, c.format);
    EXPECT_EQ(back.metadata.crs, "EPSG:32615+5773");
    EXPECT_EQ(back.metadata.vertical_crs_code, 5773);
    expect_within_half_step(back.cloud, cloud, Vec3::Constant(0.01));
    EXPECT_EQ(back.cloud.classification, cloud.classification);
    EXPECT_EQ(back.cloud.gps_time, cloud.gps_time);
    EXPECT_EQ(back.cloud.colours, cloud.colours);
    EXPECT_EQ(back.cloud.scalars.size(), 2U);
  }
}

TEST(LasWrite, EveryScalarTypeAndItsLimits) {
  const testing::TempFolder folder;
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 1, 1}};
  const auto add = [&](const char* name, ScalarType type, double lo, double hi) {
    cloud.add_scalar(name, type, name).values = {lo, hi};
  };
  add("u8", ScalarType::u8, 0, 255);
  add("i8", ScalarType::i8, -128, 127);
  add("u16", ScalarType::u16, 0, 65535);
  add("i16", ScalarType::i16, -32768, 32767);
  add("u32", ScalarType::u32, 0, 4294967295.0);
  add("i32", ScalarType::i32, -2147483648.0, 2147483647.0);
  add("u64", ScalarType::u64, 0, 9007199254740992.0);
  add("i64", ScalarType::i64, -9007199254740992.0, 9007199254740992.0);
  add("f32", ScalarType::f32, -0.25, 1e30F);
  add("f64", ScalarType::f64, -1e-300, 1e300);
  write_las(folder / "a.las", cloud);
  const LasCloud back = read_las(folder / "a.las");
  ASSERT_EQ(back.cloud.scalars.size(), cloud.scalars.size());
  for (std::size_t c = 0; c < cloud.scalars.size(); ++c) {
    EXPECT_EQ(back.cloud.scalars[c].name, cloud.scalars[c].name);
    EXPECT_EQ(back.cloud.scalars[c].type, cloud.scalars[c].type);
    EXPECT_EQ(back.cloud.scalars[c].values, cloud.scalars[c].values) << cloud.scalars[c].name;
  }
  cloud.scalars[0].values[1] = 256;
  EXPECT_THROW(write_las(folder / "b.las", cloud), base::Error);
}

TEST(LasWrite, ValuesThatAreNotFiniteBecomeDeclaredNoData) {
  const testing::TempFolder folder;
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, 1, 1}};
  cloud.add_scalar("h", ScalarType::f32, "").values = {1.5, NAN};
  write_las(folder / "a.las", cloud);
  const LasCloud back = read_las(folder / "a.las");
  EXPECT_EQ(back.cloud.scalars[0].values, (std::vector<double>{1.5, -9999.0}));
  ASSERT_EQ(back.metadata.dimensions.size(), 1U);
  EXPECT_EQ(back.metadata.dimensions[0].no_data, -9999.0);
}

TEST(LasWrite, RefusesWhatDoesNotFit) {
  const testing::TempFolder folder;
  PointCloud cloud;
  cloud.positions = {{0, 0, 0}, {1, NAN, 1}};
  EXPECT_THROW(write_las(folder / "a.las", cloud), base::Error);
  cloud.positions = {{0, 0, 0}, {3e6, 0, 0}};
  LasWriteOptions options;
  options.scale = Vec3::Constant(1e-3);
  options.offset = Vec3::Zero();
  try {
    write_las(folder / "a.las", cloud, options);
    FAIL() << "3 000 km fit 32 bits of millimetres";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_argument);
    EXPECT_THAT(error.what(), HasSubstr("axis x"));
  }
  // Without a given scale a coarser one is chosen.
  write_las(folder / "a.las", cloud);
  EXPECT_EQ(read_las(folder / "a.las").cloud.positions[1].x(), 3e6);
  EXPECT_FALSE(std::filesystem::exists(folder / "b.las"));
}

TEST(LasWrite, EmptyAndSinglePoint) {
  const testing::TempFolder folder;
  PointCloud cloud;
  write_las(folder / "a.las", cloud);
  EXPECT_EQ(read_las(folder / "a.las").cloud.size(), 0U);
  cloud.positions = {{5e5, 5e6, 100}};
  write_las(folder / "a.las", cloud);
  EXPECT_EQ(read_las(folder / "a.las").cloud.positions[0], cloud.positions[0]);
}

// What a reader kept of the source goes back: scale, offset, records, identifiers, standard fields.
TEST(LasWrite, KeepsWhatTheSourceHeld) {
  const testing::TempFolder folder;
  LasColumns columns;
  columns.standard_fields = true;
  const LasCloud source = read_las(pdal("interesting.las"), columns);
  LasWriteOptions options;
  options.source = &source.metadata;
  options.crs = source.metadata.crs;
  write_las(folder / "a.las", source.cloud, options);
  const LasCloud back = read_las(folder / "a.las", columns);
  EXPECT_EQ(back.metadata.scale, source.metadata.scale);
  EXPECT_EQ(back.metadata.offset, source.metadata.offset);
  EXPECT_EQ(back.metadata.system_identifier, source.metadata.system_identifier);
  EXPECT_EQ(back.metadata.creation_year, source.metadata.creation_year);
  EXPECT_EQ(back.metadata.crs, source.metadata.crs);
  ASSERT_EQ(back.metadata.records.size(), source.metadata.records.size());
  EXPECT_EQ(back.metadata.records[0].data, source.metadata.records[0].data);
  EXPECT_EQ(back.cloud.positions, source.cloud.positions);  // to the last bit
  ASSERT_EQ(back.cloud.scalars.size(), source.cloud.scalars.size());
  for (std::size_t c = 0; c < back.cloud.scalars.size(); ++c) {
    const std::string& name = back.cloud.scalars[c].name;
    if (name == "scan_angle_deg") {
      // Steps of 0.006 degrees in format 7.
      for (std::size_t i = 0; i < back.cloud.size(); ++i)
        ASSERT_NEAR(back.cloud.scalars[c].values[i], source.cloud.scalars[c].values[i], 0.003 + 1e-9);
    } else {
      EXPECT_EQ(back.cloud.scalars[c].values, source.cloud.scalars[c].values) << name;
    }
  }
  std::uint64_t returns = 0;
  for (const auto n : back.metadata.points_by_return) returns += n;
  EXPECT_EQ(returns, back.cloud.size());
}

TEST(LasWrite, SameBytesEveryTime) {
  const testing::TempFolder folder;
  write_las(folder / "a.las", utm_cloud());
  write_las(folder / "b.las", utm_cloud());
  EXPECT_EQ(base::read_file(folder / "a.las"), base::read_file(folder / "b.las"));
}

TEST(LasReader, PiecesEqualTheWhole) {
  const LasReader reader(pdal("sample_c_thin.las"));
  const PointCloud whole = reader.read(0, reader.metadata().point_count);
  const PointCloud head = reader.read(0, 1000), tail = reader.read(1000, 1'000'000);
  ASSERT_EQ(head.size() + tail.size(), whole.size());
  EXPECT_EQ(head.positions.back(), whole.positions[999]);
  EXPECT_EQ(tail.positions.front(), whole.positions[1000]);
  EXPECT_EQ(tail.classification.back(), whole.classification.back());
  EXPECT_EQ(reader.read(1'000'000'000, 5).size(), 0U);
}

// Facts of the samples as their producers state them (and as an independent decoder prints them).
struct Sample {
  const char* file;
  int minor, format;
  std::size_t points;
  const char* crs;
  Vec3 first;
};

class LasSamples : public ::testing::TestWithParam<Sample> {};

TEST_P(LasSamples, HeaderAndFirstPoint) {
  const Sample& s = GetParam();
  const LasCloud las = read_las(pdal(s.file));
  EXPECT_EQ(las.metadata.minor_version, s.minor);
  EXPECT_EQ(las.metadata.point_format, s.format);
  EXPECT_EQ(las.cloud.size(), s.points);
  EXPECT_THAT(las.metadata.crs, ::testing::StartsWith(s.crs));
  if (std::string_view(s.crs).empty()) {
    EXPECT_EQ(las.metadata.crs, "");
  }
  EXPECT_LT((las.cloud.positions[0] - s.first).norm(), 1e-6);  // decimals of the table
  // Bounds of the points lie in those of the header, to a step.
  const double step = las.metadata.scale.maxCoeff();
  for (const auto& p : las.cloud.positions)
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_GE(p[axis], las.metadata.bounds.min[axis] - step);
      ASSERT_LE(p[axis], las.metadata.bounds.max[axis] + step);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Pdal, LasSamples,
    ::testing::Values(Sample{"1.2-with-color.las", 2, 3, 1065, "", {637012.24, 849028.31, 431.66}},
                      Sample{"interesting.las", 2, 3, 1065, "PROJCS[\"NAD_1983_Oregon", {637012.24, 849028.31, 431.66}},
                      Sample{"extrabytes.las", 4, 3, 1065, "", {637012.24, 849028.31, 431.66}},
                      Sample{"utm15.las", 2, 3, 1, "EPSG:26915", {470692.44, 4602888.90, 16.0}},
                      Sample{"utm17.las", 2, 3, 10, "EPSG:32617", {289814.15, 4320978.61, 170.76}},
                      Sample{"autzen-utm.las", 2, 3, 1065, "EPSG:26910", {494428.61, 4877455.58, 131.57}},
                      Sample{"lots_of_vlr.las", 1, 1, 1, "", {715001.346, 839349.171, 17.275}},
                      Sample{"hextest.las", 2, 0, 8, "", {0, 0, 0}}),
    [](const auto& tested) {
      std::string name = tested.param.file;
      for (char& c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
      return name;
    });

TEST(LasReader, ReadsDescribedExtraBytes) {
  const LasCloud las = read_las(pdal("extrabytes.las"));
  ASSERT_EQ(las.cloud.scalars.size(), 7U);
  // The producer copied the standard fields into extra dimensions: they must agree point by point.
  const auto* intensity = las.cloud.scalar("Intensity");
  const auto* time = las.cloud.scalar("Time");
  ASSERT_NE(intensity, nullptr);
  ASSERT_NE(time, nullptr);
  for (std::size_t i = 0; i < las.cloud.size(); ++i) {
    ASSERT_EQ(intensity->values[i], las.cloud.intensity[i]);
    ASSERT_EQ(std::floor(time->values[i]), std::floor(las.cloud.gps_time[i]));
    for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(las.cloud.scalars[k].values[i] * 257.0, las.cloud.colours[i][k]);
  }
}

TEST(LasReader, KeepsManyRecords) {
  EXPECT_EQ(LasReader(pdal("lots_of_vlr.las")).metadata().records.size(), 388U);
}

TEST(LasReader, RefusesCompressedPointsWithARemedy) {
  const testing::TempFolder folder;
  std::string file = base::read_file(pdal("utm17.las"));
  file[104] = static_cast<char>(128 + 3);
  base::write_file(folder / "a.laz", file);
  try {
    (void)read_las(folder / "a.laz");
    FAIL() << "read compressed points";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_THAT(error.hint(), HasSubstr("laszip"));
    EXPECT_EQ(error.record(), "byte 104");
  }
}

TEST(LasReader, NamesTheOffsetOfATruncatedFile) {
  const testing::TempFolder folder;
  const std::string file = base::read_file(pdal("utm17.las"));
  base::write_file(folder / "a.las", file.substr(0, file.size() - 1));
  try {
    (void)read_las(folder / "a.las");
    FAIL() << "read a truncated file";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_EQ(error.record(), "byte 107");
    EXPECT_THAT(error.what(), HasSubstr("10 points of 34 bytes"));
  }
}

TEST(LasUnits, KnowsMetreAndBothFeet) {
  EXPECT_EQ(las_unit_metres(9001), 1.0);
  EXPECT_EQ(las_unit_metres(9002), 0.3048);
  EXPECT_NEAR(las_unit_metres(9003), 0.3048006096, 1e-10);  // decimals of the constant
  EXPECT_EQ(las_unit_metres(0), 0.0);
}

}  // namespace
}  // namespace cairn::io
