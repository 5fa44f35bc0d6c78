#include "io/image_crop.hpp"

#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/image.hpp"
#include "support/data.hpp"

namespace cairn::io {
namespace {

const std::filesystem::path kPhoto = testing::sample("brighton_beach/images_1600/DJI_0020.JPG");  // 1600 x 900

ImageHeader header_of(const std::string& jpeg) {
  const testing::TempFolder folder;
  base::write_file(folder / "crop.jpg", jpeg);
  return read_image_header(folder / "crop.jpg");
}

TEST(CropJpegs, GivesASquareOfTheAskedSizeForEachBox) {
  const auto crops = crop_jpegs(kPhoto, {{100, 100, 400, 300}, {800, 400, 820, 410}});
  ASSERT_EQ(crops.size(), 2U);
  EXPECT_EQ(header_of(crops[0]).width_px, 224);
  EXPECT_EQ(header_of(crops[0]).height_px, 224);
  EXPECT_EQ(header_of(crops[1]).width_px, 48) << "small parts are not enlarged";
}

TEST(CropJpegs, ABoxAtTheBorderKeepsItsSquareInside) {
  const auto crops = crop_jpegs(kPhoto, {{0, 0, 60, 60}, {1560, 860, 1600, 900}});
  EXPECT_EQ(header_of(crops[0]).width_px, header_of(crops[0]).height_px);
  EXPECT_FALSE(crops[1].empty());
}

TEST(CropJpegs, ABoxOutsideGivesNothing) {
  EXPECT_TRUE(crop_jpegs(kPhoto, {{5000, 100, 5100, 200}})[0].empty());
}

TEST(CropJpegs, EqualInputsGiveEqualBytes) {
  EXPECT_EQ(crop_jpegs(kPhoto, {{100, 100, 400, 300}}), crop_jpegs(kPhoto, {{100, 100, 400, 300}}));
}

TEST(CropParts, TellWhereTheyWereTaken) {
  const auto parts = crop_parts(kPhoto, {{100, 100, 400, 300}, {5000, 100, 5100, 200}});
  // The longer side 300, with 0.6 of it on both sides: 660 about (250, 200), moved inside the photograph.
  EXPECT_EQ(parts[0].x_px, 0.0);
  EXPECT_EQ(parts[0].y_px, 0.0);
  EXPECT_NEAR(parts[0].scale, 224.0 / 660.0, 1e-12);
  EXPECT_EQ(parts[0].side_px, 224.0);
  EXPECT_TRUE(parts[1].jpeg.empty());
}

TEST(CropJpegs, AFileThatIsNoPhotographIsRefused) {
  const testing::TempFolder folder;
  base::write_file(folder / "a.jpg", "not a photograph");
  EXPECT_THROW((void)crop_jpegs(folder / "a.jpg", {{0, 0, 5, 5}}), base::Error);
  EXPECT_THROW((void)crop_jpegs(folder / "absent.jpg", {{0, 0, 5, 5}}), base::Error);
}

}  // namespace
}  // namespace cairn::io
