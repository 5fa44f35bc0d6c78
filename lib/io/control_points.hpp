// Surveyed ground points and where they are seen: OpenDroneMap's gcp_list.txt, OpenSfM's ground_control_points.json,
// and a table of cairn's own.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/reject.hpp"
#include "survey/control_point.hpp"
#include "survey/survey.hpp"

namespace cairn::io {

struct ControlPointOptions {
  std::string crs;           // over what the file declares: "EPSG:n", WKT, PROJ, or "local" = the survey's frame
  double image_scale = 1.0;  // pixels of the file * this = pixels of the survey's images, > 0
  double sigma_xy_m = 0.02, sigma_z_m = 0.03;  // 1 sigma where the file gives none, > 0
};

struct ControlPoints {
  std::vector<survey::ControlPoint> points;  // by name; local ENU of the survey
  std::vector<base::Reject> rejects;  // points without a place or a height, observations of images the survey has not
  std::string crs;                    // read or given
  std::string convention;             // one sentence: what was read, and how it was converted
};

// By the name's ending: `.json` = OpenSfM, `.csv` = cairn, else gcp_list.txt.
//
// gcp_list.txt: first line a CRS ("EPSG:32615", "WGS84", "WGS84 UTM 15N", a PROJ string), then
//   x y z px py image [name]
// separated by blanks or tabs; x = easting or longitude. Pixels are counted from the first pixel's centre, as OpenSfM
// reads them: half a pixel is added. Rows without a name belong to one point where their coordinates are the same text.
// A z that is NaN makes a reject.
//
// ground_control_points.json: WGS84 latitude, longitude, altitude; projections in normalised coordinates
// (io/opensfm.hpp). "role": "metrics_only" makes a check point.
//
// Own table: columns name,x,y,z,image,x_px,y_px, optional sigma_xy_m, sigma_z_m, use (control or check), one row an
// observation, pixels in the corner convention; the CRS in a comment line before the header, "# crs: EPSG:32615".
//
// Heights: of the survey's datum where the CRS says nothing of heights; else converted to the ellipsoid, which the
// survey's heights must then be above (crs_mismatch). Images are joined by the last part of their name.
// Throws invalid_input with file, line and value; crs_mismatch for a CRS that is missing, unknown or does not fit.
[[nodiscard]] ControlPoints read_control_points(const std::filesystem::path& path, const survey::Survey& survey,
                                                const ControlPointOptions& options = {});

// The header line of a gcp_list.txt as a CRS text that geodesy reads: "WGS84 UTM 15N" -> "EPSG:32615".
// Throws crs_mismatch for a line that names none.
[[nodiscard]] std::string gcp_crs(std::string_view header);

}  // namespace cairn::io
