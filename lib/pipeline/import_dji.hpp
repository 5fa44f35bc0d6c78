// DJI photographs (EXIF + XMP) -> survey.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/image_metadata.hpp"
#include "pipeline/import_survey.hpp"

namespace cairn::pipeline {

struct ImportDjiInputs {
  ImportInputs common;
  std::filesystem::path images;
  // Height of the take-off point [m], and what it is measured from: "ellipsoidal" or "egm96".
  std::optional<double> takeoff_height_m;
  std::string takeoff_datum = "ellipsoidal";
  // Image stems whose pixels were turned by 180 degrees after the flight: names, ranges A-B, comma-separated.
  std::string rotate;
  // Intrinsics instead of those of the photographs, as parse_camera reads them; "" = none.
  std::string camera;
};

// Sigmas where the aircraft gives none. Consumer GNSS; the barometer over one flight; gimbal attitude
// (on the sample survey yaw is off by up to 3.6 and the axis by up to 2.4 degrees).
inline constexpr double kGnssSigmaXyM = 3.0, kBarometerSigmaZM = 1.0, kGimbalSigmaDeg = 3.0;

// Attitude: gimbal yaw, pitch, roll; flight yaw is used only where there is no gimbal yaw (assumed).
// Heights, the first that applies: take-off height + RelativeAltitude (ellipsoidal; egm96 is
// converted); AbsoluteAltitude where every frame has RtkFlag >= 16 (ellipsoidal); RelativeAltitude
// alone (relative_takeoff). AbsoluteAltitude without RTK is never used.
// Origin: the given one, else the first frame's position to 4 decimals of a degree at the take-off
// height (0 for relative heights, a whole metre for RTK).
// Camera: the given one, else DewarpData where there is any, else the 35 mm equivalent focal length over
// 36 mm of width (off by up to 3 %: makers round it, and some mean the diagonal), principal point at the
// centre; the size is that of the image files.
// Frames without position, attitude or height are rejected, with the reason; with strict they throw.
[[nodiscard]] Outcome import_dji(const ImportDjiInputs& in, const std::filesystem::path& out, base::RunContext& ctx);

// Which of the stems a list such as "DJI_0024-DJI_0029,DJI_0035" names. Throws invalid_argument for a
// stem or range that names none of them.
[[nodiscard]] std::vector<bool> stems_named(const std::string& list, const std::vector<std::string>& stems);

// The camera of one photograph; empty where it says nothing of its focal length. `from_dewarp` tells
// where it came from. Id and name are left to the caller.
[[nodiscard]] std::optional<survey::Camera> dji_camera(const io::ImageMetadata& metadata, bool& from_dewarp);

}  // namespace cairn::pipeline
