#include "io/image.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

namespace fs = std::filesystem;

fs::path photograph() {
  return testing::sample("brighton_beach/images_1600/DJI_0018.JPG");
}

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

fs::path written(const testing::TempFolder& folder, const std::string& name, const std::string& bytes) {
  std::ofstream(folder / name, std::ios::binary) << bytes;
  return folder / name;
}

// 8-bit grey, 3 x 2, all black, with valid checksums.
const std::string kPng(
    "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x03\0\0\0\x02\x08\0\0\0\0\xb8\x1f\x39\xc6\0\0\0\nIDATx\xda\x63\x60\x80\x03\0\0"
    "\x08"
    "\0\x01\x2d\x19\xf6\x5c\0\0\0\0IEND\xae\x42\x60\x82",
    67);

TEST(ImageHeader, SizeOfAPhotograph) {
  const auto header = read_image_header(photograph());
  EXPECT_EQ(header.format, "JPEG");
  EXPECT_EQ(header.width_px, 1600);
  EXPECT_EQ(header.height_px, 900);
  EXPECT_EQ(header.channels, 3);
  EXPECT_EQ(header.file_bytes, fs::file_size(photograph()));
}

TEST(ImageHeader, SizeOfAPng) {
  const testing::TempFolder folder;
  const auto header = read_image_header(written(folder, "a.png", kPng));
  EXPECT_EQ(header.format, "PNG");
  EXPECT_EQ(header.width_px, 3);
  EXPECT_EQ(header.height_px, 2);
  EXPECT_EQ(header.channels, 1);
}

TEST(ImageHeader, EveryTruncationIsRefused) {
  const testing::TempFolder folder;
  const auto whole = bytes_of(photograph());
  for (std::size_t i = 0; i < 200; ++i) {
    const auto path = written(folder, "cut.jpg", whole.substr(0, i * (whole.size() - 1) / 200));
    EXPECT_THROW(static_cast<void>(read_image_header(path)), base::Error) << i;
  }
  for (std::size_t length = 0; length < kPng.size() - 8; ++length)
    EXPECT_THROW(static_cast<void>(read_image_header(written(folder, "cut.png", kPng.substr(0, length)))), base::Error)
        << length;
}

TEST(ImageHeader, OtherFilesAreRefusedByName) {
  const testing::TempFolder folder;
  try {
    static_cast<void>(read_image_header(written(folder, "a.jpg", "GIF89a and more")));
    FAIL() << "not refused";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_EQ(error.file(), (folder / "a.jpg").string());
    EXPECT_EQ(error.allowed(), "a JPEG or PNG file");
  }
  EXPECT_THROW(static_cast<void>(read_image_header(folder / "none.jpg")), base::Error);
}

TEST(GreyImage, DecodesWholeOrReduced) {
  const auto whole = read_grey_image(photograph());
  EXPECT_EQ(whole.width_px, 1600U);
  EXPECT_EQ(whole.values.size(), 1600U * 900U);
  const auto half = read_grey_image(photograph(), 1000);
  EXPECT_EQ(half.width_px, 800U);
  EXPECT_EQ(half.height_px, 450U);
  // Same picture: means of 50 x 50 blocks agree within JPEG's rounding.
  constexpr double kGrey = 3.0;
  double a = 0.0, b = 0.0;
  for (std::size_t r = 0; r < 50; ++r)
    for (std::size_t c = 0; c < 50; ++c) {
      b += half.at(100 + r, 200 + c);
      for (std::size_t k = 0; k < 4; ++k) a += 0.25 * whole.at(200 + 2 * r + k / 2, 400 + 2 * c + k % 2);
    }
  EXPECT_NEAR(a / 2500.0, b / 2500.0, kGrey);
}

TEST(GreyImage, SampleIsBilinearInTheCornerConvention) {
  const geometry::GreyImage image{2, 2, {0, 100, 200, 100}};
  EXPECT_DOUBLE_EQ(*image.sample({0.5, 0.5}), 0.0);
  EXPECT_DOUBLE_EQ(*image.sample({1.0, 0.5}), 50.0);
  EXPECT_DOUBLE_EQ(*image.sample({1.0, 1.0}), 100.0);
  EXPECT_FALSE(image.sample({0.4, 0.5}).has_value());
  EXPECT_FALSE(image.sample({1.6, 0.5}).has_value());
}

TEST(ImageWrite, PngKeepsEveryPixelAndJpegNearly) {
  const testing::TempFolder folder;
  constexpr std::int64_t kWidth = 37, kHeight = 21;
  std::vector<std::uint8_t> rgb;
  for (std::int64_t i = 0; i < kWidth * kHeight; ++i)
    for (const std::int64_t channel : {5 * (i % kWidth), 9 * (i / kWidth), std::int64_t{40}})
      rgb.push_back(static_cast<std::uint8_t>(channel));
  write_rgb_image(folder / "a.png", kWidth, kHeight, rgb);
  const auto header = read_image_header(folder / "a.png");
  EXPECT_EQ(header.width_px, kWidth);
  EXPECT_EQ(header.height_px, kHeight);
  EXPECT_EQ(header.channels, 3);
  // Brightness by ITU-R BT.601, which a swap of red and blue would change.
  const auto grey = read_grey_image(folder / "a.png");
  for (std::size_t i = 0; i < grey.values.size(); ++i)
    ASSERT_NEAR(grey.values[i], 0.299 * rgb[3 * i] + 0.587 * rgb[3 * i + 1] + 0.114 * rgb[3 * i + 2], 1.0) << i;
  write_rgb_image(folder / "a.jpg", kWidth, kHeight, rgb, 95);
  EXPECT_EQ(read_image_header(folder / "a.jpg").format, "JPEG");
  const auto coded = read_grey_image(folder / "a.jpg");
  for (std::size_t i = 0; i < coded.values.size(); ++i) ASSERT_NEAR(coded.values[i], grey.values[i], 8.0) << i;
}

TEST(ImageWrite, SixteenBitsGoThroughUnchanged) {
  const testing::TempFolder folder;
  const std::vector<std::uint16_t> values = {0, 1, 255, 256, 4660, 65535};
  write_grey16_png(folder / "d.png", 3, 2, values);
  const auto image = read_grey16_png(folder / "d.png");
  EXPECT_EQ(image.width_px, 3);
  EXPECT_EQ(image.height_px, 2);
  EXPECT_EQ(image.values, values);
  EXPECT_THROW(static_cast<void>(read_grey16_png(photograph())), base::Error);
}

TEST(ImageWrite, RefusesWhatItCannotWrite) {
  const testing::TempFolder folder;
  const std::vector<std::uint8_t> rgb(3 * 4, 0);
  EXPECT_THROW(write_rgb_image(folder / "a.bmp", 2, 2, rgb), base::Error);
  EXPECT_THROW(write_rgb_image(folder / "a.png", 3, 2, rgb), base::Error);
  EXPECT_THROW(write_rgb_image(folder / "none" / "a.png", 2, 2, rgb), base::Error);
  EXPECT_FALSE(fs::exists(folder / "a.png"));
}

}  // namespace
}  // namespace cairn::io
