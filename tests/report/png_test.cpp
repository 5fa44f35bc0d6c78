#include "report/png.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "base/error.hpp"
#include "report/base64.hpp"

namespace cairn::report {
namespace {

cv::Mat decoded(const std::string& png) {
  const std::vector<unsigned char> bytes(png.begin(), png.end());
  return cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
}

// Oracle: OpenCV's decoder.
TEST(Png, another_library_reads_every_pixel_of_a_colour_image) {
  RgbaImage image{37, 23, {}};
  for (std::size_t i = 0; i < 37 * 23; ++i)
    image.pixels.push_back({static_cast<std::uint8_t>(i * 7), static_cast<std::uint8_t>(i * i),
                            static_cast<std::uint8_t>(255 - i), static_cast<std::uint8_t>(i % 3 == 0 ? 0 : 255)});
  const cv::Mat back = decoded(encode_png(image));
  ASSERT_EQ(back.type(), CV_8UC4);
  ASSERT_EQ(back.cols, 37);
  ASSERT_EQ(back.rows, 23);
  for (int r = 0; r < 23; ++r)
    for (int c = 0; c < 37; ++c) {
      const auto pixel = back.at<cv::Vec4b>(r, c);
      const Rgba& want = image.pixels[static_cast<std::size_t>(r * 37 + c)];
      ASSERT_EQ((Rgba{pixel[2], pixel[1], pixel[0], pixel[3]}), want) << r << ' ' << c;
    }
}

TEST(Png, another_library_reads_every_pixel_of_an_indexed_image) {
  IndexedImage image{19, 11, {{10, 20, 30, 255}, {200, 100, 0, 128}, {0, 0, 0, 0}}, {}};
  for (std::size_t i = 0; i < 19 * 11; ++i) image.pixels.push_back(static_cast<std::uint8_t>(i % 3));
  const cv::Mat back = decoded(encode_png(image));
  ASSERT_EQ(back.type(), CV_8UC4);
  for (int r = 0; r < 11; ++r)
    for (int c = 0; c < 19; ++c) {
      const auto pixel = back.at<cv::Vec4b>(r, c);
      ASSERT_EQ((Rgba{pixel[2], pixel[1], pixel[0], pixel[3]}),
                image.palette[static_cast<std::size_t>((r * 19 + c) % 3)]);
    }
}

TEST(Png, an_image_without_pixels_is_refused) {
  EXPECT_THROW((void)encode_png(RgbaImage{0, 5, {}}), base::Error);
}

// RFC 4648, section 10.
TEST(Base64, matches_the_published_vectors) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64("\xFF\xFE\xFD"), "//79");
}

}  // namespace
}  // namespace cairn::report
