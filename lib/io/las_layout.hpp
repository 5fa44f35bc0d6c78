// Where each field of a LAS point record lies (LAS 1.4-R16, tables 7 to 21). Internal to the LAS part.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "geometry/point_cloud.hpp"

namespace cairn::io::las {

// Offsets in bytes; 0 = the format has no such field. Fields shared by all: x, y, z at 0, 4, 8 and intensity at 12.
struct PointLayout {
  std::uint16_t length = 0;  // of the standard fields
  bool extended = false;     // formats 6 to 10
  std::uint16_t classification = 0, user_data = 0, scan_angle = 0, source_id = 0;
  std::uint16_t gps_time = 0, rgb = 0, nir = 0;
};

inline constexpr int kPointFormats = 11;
inline constexpr std::array<PointLayout, kPointFormats> kLayouts = {{
    {20, false, 15, 17, 16, 18, 0, 0, 0},
    {28, false, 15, 17, 16, 18, 20, 0, 0},
    {26, false, 15, 17, 16, 18, 0, 20, 0},
    {34, false, 15, 17, 16, 18, 20, 28, 0},
    {57, false, 15, 17, 16, 18, 20, 0, 0},
    {63, false, 15, 17, 16, 18, 20, 28, 0},
    {30, true, 16, 17, 18, 20, 22, 0, 0},
    {36, true, 16, 17, 18, 20, 22, 30, 0},
    {38, true, 16, 17, 18, 20, 22, 30, 36},
    {59, true, 16, 17, 18, 20, 22, 0, 0},
    {67, true, 16, 17, 18, 20, 22, 30, 36},
}};

// Scan angle of the extended formats: 0.006 degrees a step.
inline constexpr double kScanAngleStepDeg = 0.006;

inline constexpr std::string_view kReturnNumber = "return_number";
inline constexpr std::string_view kNumberOfReturns = "number_of_returns";
inline constexpr std::string_view kScanAngle = "scan_angle_deg";
inline constexpr std::string_view kUserData = "user_data";
inline constexpr std::string_view kPointSourceId = "point_source_id";
inline constexpr std::string_view kNearInfrared = "nir";

inline constexpr std::string_view kProjectionUser = "LASF_Projection";
inline constexpr std::string_view kSpecUser = "LASF_Spec";
inline constexpr std::uint16_t kExtraBytesRecord = 4;
inline constexpr std::uint16_t kWktRecord = 2112;
inline constexpr std::uint16_t kMathTransformRecord = 2111;
inline constexpr std::uint16_t kGeoKeysRecord = 34735;
inline constexpr std::uint16_t kGeoDoublesRecord = 34736;
inline constexpr std::uint16_t kGeoTextRecord = 34737;
inline constexpr std::size_t kExtraBytesDescriptor = 192;

// Stands for a value that is not finite where the file declares no other.
inline constexpr double kNoData = -9999.0;

// Codes 1 to 10 of the extra-bytes descriptor, in the order of the specification.
inline constexpr std::array<geometry::ScalarType, 10> kExtraTypes = {
    geometry::ScalarType::u8,  geometry::ScalarType::i8,  geometry::ScalarType::u16, geometry::ScalarType::i16,
    geometry::ScalarType::u32, geometry::ScalarType::i32, geometry::ScalarType::u64, geometry::ScalarType::i64,
    geometry::ScalarType::f32, geometry::ScalarType::f64};

[[nodiscard]] constexpr std::size_t size_of(geometry::ScalarType type) {
  switch (type) {
    case geometry::ScalarType::u8:
    case geometry::ScalarType::i8: return 1;
    case geometry::ScalarType::u16:
    case geometry::ScalarType::i16: return 2;
    case geometry::ScalarType::u32:
    case geometry::ScalarType::i32:
    case geometry::ScalarType::f32: return 4;
    case geometry::ScalarType::u64:
    case geometry::ScalarType::i64:
    case geometry::ScalarType::f64: return 8;
  }
  return 8;
}

}  // namespace cairn::io::las
