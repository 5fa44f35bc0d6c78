#include "io/pcd.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using geometry::PointCloud;
using geometry::ScalarType;
using ::testing::HasSubstr;

const std::string kHead =
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\n";

template <typename T>
void put(std::string& file, T value) {
  file.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

TEST(Pcd, AllThreeEncodingsAgree) {
  const testing::TempFolder folder;
  const std::uint32_t rgb[2] = {0x00102030, 0x00FF8001};
  const float xyz[2][3] = {{1.5F, -2.0F, 3.25F}, {4.0F, 5.0F, 6.0F}};
  std::string binary = kHead + "DATA binary\n", compressed = kHead + "DATA binary_compressed\n";
  for (int i = 0; i < 2; ++i) {
    for (const float v : xyz[i]) put(binary, v);
    put(binary, rgb[i]);
  }
  // By columns, then as one run of 32 literals.
  std::string columns;
  for (int axis = 0; axis < 3; ++axis)
    for (const auto& point : xyz) put(columns, point[axis]);
  for (const std::uint32_t c : rgb) put(columns, c);
  put(compressed, std::uint32_t{33});
  put(compressed, std::uint32_t{32});
  put(compressed, std::uint8_t{31});
  compressed += columns;
  // Packed colours as the float of the same bits, and as the integer.
  const std::string ascii = kHead + "DATA ascii\n1.5 -2 3.25 1.4814e-39\n4 5 6 16744449\n";
  for (const std::string& content : {binary, compressed, ascii}) {
    base::write_file(folder / "a.pcd", content);
    const CloudData data = read_pcd(folder / "a.pcd");
    ASSERT_EQ(data.cloud.size(), 2U);
    EXPECT_EQ(data.cloud.positions[0], geometry::Vec3(1.5, -2, 3.25));
    EXPECT_EQ(data.cloud.positions[1], geometry::Vec3(4, 5, 6));
    ASSERT_EQ(data.cloud.colours.size(), 2U);
    EXPECT_EQ(data.cloud.colours[1], (std::array<std::uint16_t, 3>{0xFF * 257, 0x80 * 257, 257}));
    EXPECT_EQ(data.cloud.colours[0][0], 0x10 * 257);
  }
}

TEST(Pcd, ComesBackBitForBit) {
  const testing::TempFolder folder;
  PointCloud cloud;
  cloud.positions = {{576661.97123456789, 5188114.06123456789, 156.06}, {1, 2, 3}};
  cloud.normals = {{0, 0, 1}, {0, 1, 0}};
  cloud.colours = {{257, 0, 65535}, {0, 257 * 3, 257}};
  cloud.intensity = {0, 65535};
  cloud.classification = {2, 6};
  cloud.gps_time = {0.125, 1e9};
  cloud.add_scalar("label", ScalarType::u32, "").values = {1, 4294967295.0};
  cloud.add_scalar("h m", ScalarType::f64, "").values = {0.1, NAN};
  write_pcd(folder / "a.pcd", cloud);
  const CloudData back = read_pcd(folder / "a.pcd");
  EXPECT_EQ(back.cloud.positions, cloud.positions);
  EXPECT_EQ(back.cloud.normals, cloud.normals);
  EXPECT_EQ(back.cloud.colours, cloud.colours);
  EXPECT_EQ(back.cloud.intensity, cloud.intensity);
  EXPECT_EQ(back.cloud.classification, cloud.classification);
  EXPECT_EQ(back.cloud.gps_time, cloud.gps_time);
  EXPECT_EQ(back.cloud.scalars[0].values, cloud.scalars[0].values);
  EXPECT_EQ(back.cloud.scalars[1].name, "h_m");
  EXPECT_EQ(back.cloud.scalars[1].values, (std::vector<double>{0.1, -9999.0}));
}

TEST(Pcd, Sample) {
  const CloudData data = read_pcd(testing::test_data("pdal_samples/pcd/autzen-utm.pcd"));
  EXPECT_EQ(data.cloud.size(), 1065U);
  EXPECT_EQ(data.cloud.intensity.size(), 1065U);
  EXPECT_EQ(data.cloud.classification.size(), 1065U);
  EXPECT_EQ(data.cloud.gps_time.size(), 1065U);
  EXPECT_EQ(data.cloud.colours.size(), 1065U);
  EXPECT_LT((data.cloud.positions[0] - geometry::Vec3(494428.61, 4877455.58, 131.57)).norm(), 1e-6);  // 2 decimals
}

TEST(Pcd, SpreadsCountsAndSkipsPadding) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.pcd",
                   "VERSION .7\nFIELDS x y z f _\nSIZE 4 4 4 4 1\nTYPE F F F F U\nCOUNT 1 1 1 2 3\nWIDTH 1\nHEIGHT 1\n"
                   "DATA ascii\n1 2 3 4 5 0 0 0\n");
  const CloudData data = read_pcd(folder / "a.pcd");
  ASSERT_EQ(data.cloud.scalars.size(), 2U);
  EXPECT_EQ(data.cloud.scalars[1].name, "f_1");
  EXPECT_EQ(data.cloud.scalars[1].values[0], 5.0);
}

void expect_refused(const std::string& content, const std::string& message) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.pcd", content);
  try {
    (void)read_pcd(folder / "a.pcd");
    FAIL() << "accepted: " << content;
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_FALSE(error.record().empty());
    EXPECT_THAT(error.what(), HasSubstr(message));
  }
}

TEST(Pcd, BadInputIsRefused) {
  expect_refused("VERSION 0.7\n", "does not end");
  expect_refused(kHead + "DATA zip\n", "unknown kind of data");
  expect_refused(kHead + "DATA binary\n" + std::string(31, 'a'), "more points than the file holds");
  expect_refused(kHead + "DATA ascii\n1 2 3 4\n1 2 3\n", "more points than the file holds");
  std::string huge = kHead + "DATA binary_compressed\n";
  put(huge, std::uint32_t{4});
  put(huge, std::uint32_t{0xFFFFFFFF});
  expect_refused(huge + "abcd", "impossible");
  expect_refused("FIELDS x y z\nSIZE 4 4\nTYPE F F F\nWIDTH 1\nDATA ascii\n", "differ in length");
  expect_refused("FIELDS x y z f\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 4000000000\nWIDTH 0\nDATA ascii\n",
                 "too many values");
  expect_refused("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 18446744073709551615\nHEIGHT 2\nDATA ascii\n",
                 "whole number");
  expect_refused("FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 9223372036854775807\nHEIGHT 9\nDATA ascii\n",
                 "too large");
}

}  // namespace
}  // namespace cairn::io
