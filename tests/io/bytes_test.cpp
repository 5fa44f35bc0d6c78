#include "io/bytes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "base/atomic_file.hpp"
#include "io/lzf.hpp"
#include "io/source_facts.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

using ::testing::HasSubstr;

constexpr std::array<std::byte, 8> kBytes = {std::byte{0x01}, std::byte{0x02}, std::byte{0x03}, std::byte{0x04},
                                             std::byte{0x00}, std::byte{0x00}, std::byte{0x80}, std::byte{0x3f}};

TEST(ByteReader, ReadsBothByteOrders) {
  ByteReader little(kBytes, "f");
  EXPECT_EQ(little.read<std::uint32_t>("x"), 0x04030201U);
  EXPECT_EQ(little.read<float>("x"), 1.0F);
  ByteReader big(kBytes, "f", 0, Endian::big);
  EXPECT_EQ(big.read<std::uint16_t>("x"), 0x0102U);
}

TEST(ByteReader, NamesTheOffsetInTheFileWhereItEnds) {
  ByteReader in(kBytes, "f.las", 425);
  in.skip(4, "x");
  try {
    (void)in.read<double>("the scale");
    FAIL() << "read past the end";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_EQ(error.record(), "byte 429");
    EXPECT_THAT(error.what(), HasSubstr("the scale"));
  }
}

TEST(TextReader, CutsLinesOfAllThreeKinds) {
  TextReader in("a b\nc\r\nd\re", "f");
  EXPECT_EQ(in.next_line(), "a b");
  EXPECT_EQ(in.next_line(), "c");
  EXPECT_EQ(in.line(), 2U);
  EXPECT_EQ(in.next_line(), "d");
  EXPECT_EQ(in.next_line(), "e");
  EXPECT_EQ(in.line(), 4U);
  EXPECT_EQ(in.next_line(), std::nullopt);
}

TEST(TextReader, GivesWordsAcrossLinesWithTheirLine) {
  TextReader in("  1 2\n\n\t3\r\n4", "f", 7);
  EXPECT_EQ(in.next_word(), "1");
  EXPECT_EQ(in.line(), 7U);
  EXPECT_EQ(in.next_word(), "2");
  EXPECT_EQ(in.next_word(), "3");
  EXPECT_EQ(in.line(), 9U);
  EXPECT_EQ(in.next_word(), "4");
  EXPECT_EQ(in.line(), 10U);
  EXPECT_EQ(in.next_word(), std::nullopt);
}

TEST(ParseNumber, TakesWholeWordsOnly) {
  EXPECT_EQ(parse_number("+1.5e3"), 1500.0);
  EXPECT_EQ(parse_number("5188114.061"), 5188114.061);
  EXPECT_EQ(parse_number("1e-400"), 0.0);
  EXPECT_TRUE(std::isnan(parse_number("nan").value()));
  EXPECT_EQ(parse_number(""), std::nullopt);
  EXPECT_EQ(parse_number("1,5"), std::nullopt);
  EXPECT_EQ(parse_number("0x10"), std::nullopt);
  EXPECT_EQ(parse_number("1e400"), std::nullopt);
  EXPECT_EQ(parse_number("+-1"), std::nullopt);
}

TEST(InputFile, RefusesWhatIsNoRegularFile) {
  const testing::TempFolder folder;
  EXPECT_THROW(InputFile(folder.path()), base::Error);
  try {
    const InputFile file(folder / "absent.las");
    FAIL() << "opened a file that is not there";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::not_found);
  }
}

TEST(OutputFile, ReportsAFullDiskWithTheByteCount) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  OutputFile out("/dev/full");
  out.write(std::string_view("four"));
  try {
    out.close();
    FAIL() << "wrote to a full disk";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::resource_exhausted);
    EXPECT_EQ(error.record(), "byte 0");
  }
}

TEST(OutputFile, WritesMoreThanItsBuffer) {
  const testing::TempFolder folder;
  constexpr std::size_t kMany = 3'000'001;  // more than two buffers of 1 MiB
  {
    OutputFile out(folder / "f");
    out.write(std::string(kMany, 'a'));
    out.write(std::string_view("b"));
    out.close();
  }
  const std::string content = base::read_file(folder / "f");
  EXPECT_EQ(content.size(), kMany + 1);
  EXPECT_EQ(content.back(), 'b');
}

std::vector<std::byte> bytes(std::initializer_list<int> values) {
  std::vector<std::byte> result;
  for (const int v : values) result.push_back(static_cast<std::byte>(v));
  return result;
}

// By hand from the format: "ab" as literals, then 5 bytes copied from 2 back: "ababa".
TEST(Lzf, UnpacksLiteralsAndOverlappingCopies) {
  const auto packed = bytes({1, 'a', 'b', 3 << 5, 1});
  std::vector<std::byte> out(7);
  ASSERT_TRUE(lzf_decompress(packed, out));
  EXPECT_EQ(printable_text(out), "abababa");
}

TEST(Lzf, UnpacksLongCopies) {
  const auto packed = bytes({0, 'z', 7 << 5, 255, 0});
  std::vector<std::byte> out(1 + 7 + 255 + 2);
  ASSERT_TRUE(lzf_decompress(packed, out));
  EXPECT_EQ(printable_text(out), std::string(265, 'z'));
}

TEST(Lzf, RefusesWhatReachesOutside) {
  std::vector<std::byte> out(7);
  EXPECT_FALSE(lzf_decompress(bytes({5, 'a'}), out));                  // literals cut off
  EXPECT_FALSE(lzf_decompress(bytes({0, 'a', 3 << 5, 1}), out));       // copy from before the start
  EXPECT_FALSE(lzf_decompress(bytes({0, 'a', 7 << 5, 255, 0}), out));  // more than fits
  EXPECT_FALSE(lzf_decompress(bytes({0, 'a'}), out));                  // less than promised
  EXPECT_FALSE(lzf_decompress(bytes({0, 'a', 7 << 5}), out));          // length cut off
}

TEST(DropNonFinite, DropsPointsAndReplacesScalars) {
  CloudData data;
  data.cloud.positions = {{1, 2, 3}, {NAN, 0, 0}, {0, INFINITY, 0}, {4, 5, 6}};
  data.cloud.intensity = {1, 2, 3, 4};
  data.cloud.normals = {{0, 0, 2}, {0, 0, 1}, {0, 0, 1}, {NAN, 0, 1}};
  data.cloud.add_scalar("s", geometry::ScalarType::f32, "").values = {7, 8, 9, NAN};
  drop_non_finite(data);
  EXPECT_EQ(data.facts.dropped_points, 2U);
  ASSERT_EQ(data.cloud.size(), 2U);
  EXPECT_TRUE(data.cloud.consistent());
  EXPECT_EQ(data.cloud.positions[1], geometry::Vec3(4, 5, 6));
  EXPECT_EQ(data.cloud.intensity[1], 4);
  EXPECT_EQ(data.cloud.normals[0], geometry::Vec3(0, 0, 1));
  EXPECT_EQ(data.cloud.normals[1], geometry::Vec3(0, 0, 0));
  EXPECT_EQ(data.cloud.scalars[0].values, (std::vector<double>{7, kNoDataValue}));
  EXPECT_EQ(data.facts.warnings.size(), 3U);
}

TEST(DropNonFinite, DropsTrianglesOfDroppedVertices) {
  MeshData data;
  data.mesh.vertices = {{0, 0, 0}, {NAN, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  data.mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  drop_non_finite(data);
  ASSERT_EQ(data.mesh.vertices.size(), 3U);
  ASSERT_EQ(data.mesh.triangles.size(), 1U);
  EXPECT_EQ(data.mesh.triangles[0], (geometry::Triangle{0, 1, 2}));
  EXPECT_EQ(data.facts.dropped_faces, 1U);
}

}  // namespace
}  // namespace cairn::io
