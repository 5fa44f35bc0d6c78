#include "io/image_metadata.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/time.hpp"
#include "io/csv.hpp"
#include "support/data.hpp"
#include "support/jpeg.hpp"

namespace cairn::io {
namespace {

using testing::Exif;
using ::testing::HasSubstr;

constexpr int kLatitudeRef = 1, kLatitude = 2, kLongitudeRef = 3, kLongitude = 4, kAltitudeRef = 5, kAltitude = 6;
constexpr int kMake = 0x010F, kDateTimeOriginal = 0x9003, kSubSecOriginal = 0x9291, kFocal35 = 0xA405,
              kFocalLength = 0x920A, kWidth = 0xA002, kHeight = 0xA003, kOrientation = 0x0112;

ImageMetadata of(const std::vector<std::string>& segments) {
  const testing::TempFolder folder;
  base::write_file(folder / "t.jpg", testing::jpeg(segments));
  return read_image_metadata(folder / "t.jpg");
}

// Every value of every photograph against the table that came with the data set.
TEST(ImageMetadata, AgreesWithTheTableOfBrightonBeach) {
  CsvReader table(testing::sample("brighton_beach/exif_poses.csv"));
  const auto real = [&](const char* name) { return table.real(table.column(name)); };
  int rows = 0;
  while (table.next()) {
    const std::string image(table.text(table.column("image")));
    SCOPED_TRACE(image);
    const ImageMetadata m = read_image_metadata(testing::sample("brighton_beach/images_1600") / image);
    // The raster was reduced to 0.4; its EXIF was left alone.
    EXPECT_EQ(m.size, (ImageSize{1600, 900}));
    EXPECT_EQ(m.exif_size, (ImageSize{4000, 2250}));
    EXPECT_EQ(m.make, "DJI");
    EXPECT_EQ(m.model, "FC300S");
    EXPECT_EQ(m.software, table.text(table.column("software")));
    EXPECT_EQ(m.orientation, 1);
    constexpr double kTableDigits = 1e-9;  // degrees; the table has nine decimals
    ASSERT_TRUE(m.latitude_deg && m.longitude_deg);
    EXPECT_NEAR(*m.latitude_deg, real("latitude_deg"), kTableDigits);
    EXPECT_NEAR(*m.longitude_deg, real("longitude_deg"), kTableDigits);
    EXPECT_EQ(m.gps_altitude_m, real("gps_altitude_m"));
    EXPECT_EQ(m.focal_length_mm, real("focal_length_mm"));
    EXPECT_EQ(m.focal_length_35mm_mm, real("focal_length_35mm_mm"));
    EXPECT_EQ(m.dji.gimbal_yaw_deg, real("gimbal_yaw_deg"));
    EXPECT_EQ(m.dji.gimbal_pitch_deg, real("gimbal_pitch_deg"));
    EXPECT_EQ(m.dji.gimbal_roll_deg, real("gimbal_roll_deg"));
    EXPECT_EQ(m.dji.flight_yaw_deg, real("flight_yaw_deg"));
    EXPECT_EQ(m.dji.flight_pitch_deg, real("flight_pitch_deg"));
    EXPECT_EQ(m.dji.flight_roll_deg, real("flight_roll_deg"));
    EXPECT_EQ(m.dji.relative_altitude_m, real("xmp_relative_altitude_m"));
    EXPECT_EQ(m.dji.absolute_altitude_m, real("xmp_absolute_altitude_m"));
    EXPECT_FALSE(m.dji.rtk_flag);
    ASSERT_TRUE(m.civil_time_ns);
    std::string time = base::iso8601(*m.civil_time_ns).substr(0, 19);
    time[4] = time[7] = ':';
    time[10] = ' ';
    EXPECT_EQ(time, table.text(table.column("datetime_original")));
    ++rows;
  }
  EXPECT_EQ(rows, 18);
}

TEST(ImageMetadata, ImageWithoutTagsHasEmptyFields) {
  const ImageMetadata m = of({});
  EXPECT_EQ(m.size, (ImageSize{1600, 900}));
  EXPECT_FALSE(m.exif_size || m.civil_time_ns || m.latitude_deg || m.gps_altitude_m || m.focal_length_35mm_mm);
  EXPECT_FALSE(m.dji.gimbal_yaw_deg);
  EXPECT_EQ(m.orientation, 1);
}

TEST(ImageMetadata, ReadsPositionSouthAndWestAndBelowSeaLevel) {
  const ImageMetadata m = of({Exif()
                                  .ascii(Exif::gps, kLatitudeRef, "S")
                                  .rationals(Exif::gps, kLatitude, {{33, 1}, {30, 1}, {36, 1}})
                                  .ascii(Exif::gps, kLongitudeRef, "W")
                                  .rationals(Exif::gps, kLongitude, {{70, 1}, {15, 1}, {0, 1}})
                                  .byte(Exif::gps, kAltitudeRef, 1)
                                  .rationals(Exif::gps, kAltitude, {{4305, 10}})
                                  .segment()});
  constexpr double kRounding = 1e-12;  // degrees
  ASSERT_TRUE(m.latitude_deg && m.longitude_deg);
  EXPECT_NEAR(*m.latitude_deg, -33.51, kRounding);
  EXPECT_NEAR(*m.longitude_deg, -70.25, kRounding);
  EXPECT_EQ(m.gps_altitude_m, -430.5);
  EXPECT_EQ(m.gps_altitude_ref, 1);
}

TEST(ImageMetadata, ZeroDenominatorsAreMissingNotInfinite) {
  const auto position = [](std::pair<std::uint32_t, std::uint32_t> degrees,
                           std::pair<std::uint32_t, std::uint32_t> seconds) {
    return of({Exif()
                   .ascii(Exif::gps, kLatitudeRef, "N")
                   .rationals(Exif::gps, kLatitude, {degrees, {30, 1}, seconds})
                   .ascii(Exif::gps, kLongitudeRef, "E")
                   .rationals(Exif::gps, kLongitude, {{7, 1}, {0, 0}, {0, 0}})
                   .rationals(Exif::gps, kAltitude, {{100, 0}})
                   .rationals(Exif::photo, kFocalLength, {{0, 0}})
                   .segment()});
  };
  const ImageMetadata seconds_missing = position({46, 1}, {0, 0});
  EXPECT_EQ(seconds_missing.latitude_deg, 46.5);
  EXPECT_EQ(seconds_missing.longitude_deg, 7.0);
  EXPECT_FALSE(seconds_missing.gps_altitude_m);
  EXPECT_FALSE(seconds_missing.focal_length_mm);
  const ImageMetadata degrees_missing = position({46, 0}, {0, 1});
  EXPECT_FALSE(degrees_missing.latitude_deg);
  EXPECT_FALSE(degrees_missing.longitude_deg) << "a position is whole or not there";
}

TEST(ImageMetadata, LargeUnsignedRationalsDoNotWrap) {
  const ImageMetadata m = of({Exif().rationals(Exif::gps, kAltitude, {{4'000'000'000U, 20'000'000U}}).segment()});
  EXPECT_EQ(m.gps_altitude_m, 200.0);
}

TEST(ImageMetadata, LatitudeOffTheGlobeIsRefused) {
  try {
    (void)of({Exif()
                  .ascii(Exif::gps, kLatitudeRef, "N")
                  .rationals(Exif::gps, kLatitude, {{146, 1}, {0, 1}, {0, 1}})
                  .ascii(Exif::gps, kLongitudeRef, "E")
                  .rationals(Exif::gps, kLongitude, {{7, 1}, {0, 1}, {0, 1}})
                  .segment()});
    FAIL();
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::invalid_input);
    EXPECT_THAT(error.what(), HasSubstr("t.jpg, GPS position: latitude out of range (found 146"));
  }
}

TEST(ImageMetadata, TimeHasFractionAndBadTimesAreMissing) {
  const auto time = [](const std::string& text, const std::string& fraction) {
    return of({Exif()
                   .ascii(Exif::photo, kDateTimeOriginal, text)
                   .ascii(Exif::photo, kSubSecOriginal, fraction)
                   .segment()})
        .civil_time_ns;
  };
  EXPECT_EQ(time("2016:06:23 16:31:59", "250"), *base::civil_to_ns(2016, 6, 23, 16, 31, 59.25));
  EXPECT_FALSE(time("0000:00:00 00:00:00", ""));
  EXPECT_FALSE(time("    :  :     :  :  ", ""));
  EXPECT_FALSE(time("2016:06:31 16:31:59", ""));
  EXPECT_FALSE(time("2016-06-23T16:31:59Z", ""));
}

TEST(ImageMetadata, ReadsOpticsAndOrientation) {
  const ImageMetadata m = of({Exif()
                                  .ascii(Exif::main, kMake, "DJI")
                                  .number(Exif::main, kOrientation, 6)
                                  .number(Exif::photo, kFocal35, 24)
                                  .rationals(Exif::photo, kFocalLength, {{88, 10}})
                                  .number(Exif::photo, kWidth, 5472)
                                  .number(Exif::photo, kHeight, 3648)
                                  .segment()});
  EXPECT_EQ(m.make, "DJI");
  EXPECT_EQ(m.orientation, 6);
  EXPECT_EQ(m.focal_length_35mm_mm, 24.0);
  EXPECT_EQ(m.focal_length_mm, 8.8);
  EXPECT_EQ(m.exif_size, (ImageSize{5472, 3648}));
  EXPECT_EQ(m.size, (ImageSize{1600, 900})) << "the raster, not the tag";
  EXPECT_FALSE(of({Exif().number(Exif::photo, kFocal35, 0).segment()}).focal_length_35mm_mm) << "0 means not known";
}

constexpr const char* kNamespace = "xmlns:drone-dji=\"http://www.dji.com/drone-dji/1.0/\"";

TEST(ImageMetadata, DjiAttributesAndElementsAreTheSame) {
  const std::string attributes =
      std::string("<rdf:Description ") + kNamespace +
      " drone-dji:GimbalYawDegree=\"+45.50\" drone-dji:GimbalPitchDegree=\"-90.00\""
      " drone-dji:RelativeAltitude=\"+39.80\" drone-dji:RtkFlag=\"50\""
      " drone-dji:RtkStdHgt=\"0.021\" drone-dji:CamReverse=\"1\""
      " drone-dji:AltitudeType=\"RtkAlt\" drone-dji:DewarpFlag=\"1\" drone-dji:GpsLongtitude=\"+7.25\""
      " drone-dji:DewarpData=\"2020-01-01;1,2,3\"/>";
  const std::string elements =
      std::string("<rdf:Description ") + kNamespace +
      "><drone-dji:GimbalYawDegree>+45.50</drone-dji:GimbalYawDegree>"
      "<drone-dji:GimbalPitchDegree>-90.00</drone-dji:GimbalPitchDegree>"
      "<drone-dji:RelativeAltitude>+39.80</drone-dji:RelativeAltitude><drone-dji:RtkFlag>50</drone-dji:RtkFlag>"
      "<drone-dji:RtkStdHgt>0.021</drone-dji:RtkStdHgt><drone-dji:CamReverse>1</drone-dji:CamReverse>"
      "<drone-dji:AltitudeType>RtkAlt</drone-dji:AltitudeType><drone-dji:DewarpFlag>1</"
      "drone-dji:DewarpFlag><drone-dji:GpsLongtitude>+7.25</drone-dji:GpsLongtitude>"
      "<drone-dji:DewarpData>2020-01-01;1,2,3</drone-dji:DewarpData></rdf:Description>";
  for (const auto& rdf : {attributes, elements}) {
    const DjiMetadata d = of({testing::xmp_segment(rdf)}).dji;
    EXPECT_EQ(d.gimbal_yaw_deg, 45.5);
    EXPECT_EQ(d.gimbal_pitch_deg, -90.0);
    EXPECT_EQ(d.relative_altitude_m, 39.8);
    EXPECT_EQ(d.rtk_flag, 50);
    EXPECT_EQ(d.rtk_std_hgt_m, 0.021);
    EXPECT_TRUE(d.camera_reversed);
    EXPECT_TRUE(d.dewarped);
    EXPECT_EQ(d.altitude_type, "RtkAlt");
    EXPECT_EQ(d.longitude_deg, 7.25);
    EXPECT_EQ(d.dewarp_data, "2020-01-01;1,2,3");
    EXPECT_FALSE(d.gimbal_roll_deg);
    EXPECT_FALSE(d.flight_yaw_deg);
  }
}

TEST(ImageMetadata, DjiValuesThatAreNoNumbersAreMissing) {
  const DjiMetadata d = of({testing::xmp_segment(std::string("<rdf:Description ") + kNamespace +
                                                 " drone-dji:GimbalYawDegree=\"nan\" drone-dji:RtkFlag=\"\""
                                                 " drone-dji:GimbalPitchDegree=\"down\"/>")})
                            .dji;
  EXPECT_FALSE(d.gimbal_yaw_deg || d.gimbal_pitch_deg || d.rtk_flag);
}

// Metadata cut or damaged anywhere gives fields or a base::Error, nothing else.
TEST(ImageMetadata, DamagedMetadataNeverEscapes) {
  const std::string photo =
      base::read_file(testing::sample("brighton_beach/images_1600/DJI_0018.JPG")).substr(0, 80000);
  int readable = 0, refused = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    std::string bytes = photo;
    bytes[20 + i * 37 % 12000] = static_cast<char>(i * 151 & 0xFF);
    try {
      (void)image_metadata_of(bytes, "t.jpg");
      ++readable;
    } catch (const base::Error&) {
      ++refused;
    }
  }
  EXPECT_EQ(readable + refused, 400);
  EXPECT_GT(readable, 0);
}

}  // namespace
}  // namespace cairn::io
