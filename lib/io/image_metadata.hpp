// What a photograph says about itself: size, time, position, optics, DJI's attitude (EXIF and XMP).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace cairn::io {

struct ImageSize {
  std::int64_t width_px = 0, height_px = 0;

  friend bool operator==(const ImageSize&, const ImageSize&) = default;
};

// XMP namespace drone-dji, attribute or element form. Angles as written: NED, order ZYX, degrees.
struct DjiMetadata {
  std::optional<double> gimbal_yaw_deg, gimbal_pitch_deg, gimbal_roll_deg;
  std::optional<double> flight_yaw_deg, flight_pitch_deg, flight_roll_deg;
  std::optional<double> relative_altitude_m;  // above the take-off point
  std::optional<double> absolute_altitude_m;  // barometric unless RTK
  std::optional<std::int64_t> rtk_flag;       // 0 none, 16 single, 32..49 float, 50 fixed
  std::optional<double> rtk_std_lon_m, rtk_std_lat_m, rtk_std_hgt_m;
  std::optional<double> latitude_deg, longitude_deg;  // of newer models; else EXIF only
  std::string altitude_type;                          // "RtkAlt", "GpsFusionAlt"; "" = not said
  std::string dewarp_data;                            // "date;fx,fy,cx,cy,k1,k2,p1,p2,k3", cx, cy from the photo centre
  bool dewarped = false;                              // DewarpFlag: the camera took the distortion out itself
  bool camera_reversed = false;                       // CamReverse
};

struct ImageMetadata {
  ImageSize size;                      // of the raster, by read_image_size
  std::optional<ImageSize> exif_size;  // as EXIF claims
  std::string make, model, software;
  // DateTimeOriginal with its fraction, as if it were UTC: EXIF names no zone. Empty where absent or
  // not a date.
  std::optional<std::int64_t> civil_time_ns;
  int orientation = 1;  // EXIF tag; never applied to pixels here
  std::optional<double> focal_length_mm, focal_length_35mm_mm;
  std::optional<double> exposure_s;                   // ExposureTime
  std::optional<double> latitude_deg, longitude_deg;  // WGS84, both or none
  std::optional<double> gps_altitude_m;               // negative below sea level; the datum is not known
  std::optional<int> gps_altitude_ref;
  DjiMetadata dji;
};

// Throws invalid_input for a file whose header or metadata cannot be read, and where latitude or
// longitude is out of range. Missing tags are empty fields; rationals with denominator 0 count as
// missing. Files above 1 GiB are refused.
[[nodiscard]] ImageMetadata read_image_metadata(const std::filesystem::path& path);
// The metadata alone, from memory: `size` stays 0 x 0; `name` stands for the file.
[[nodiscard]] ImageMetadata image_metadata_of(std::string_view bytes, std::string_view name);

}  // namespace cairn::io
