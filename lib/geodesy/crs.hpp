// Coordinate reference systems, by PROJ.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "geodesy/local_frame.hpp"
#include "geometry/vec.hpp"

namespace cairn::geodesy {

// What a CRS text says about itself.
struct CrsInfo {
  std::string name;                // "WGS 84 / UTM zone 15N"
  std::string authority_code;      // "EPSG:32615" or ""
  bool geographic = false;         // axes are degrees
  bool has_vertical = false;       // compound or 3-D
  double horizontal_unit_m = 1.0;  // length of one horizontal unit; radians per unit when geographic
  double vertical_unit_m = 1.0;    // of the vertical axis where there is one
};

// Accepts "EPSG:n", WKT 1 or 2, PROJ strings. Throws crs_mismatch with the text where PROJ cannot read it.
[[nodiscard]] CrsInfo describe_crs(const std::string& crs);

// Converts between a CRS and the local frame. Only the best operation of PROJ's list is taken; where
// its grid is absent the constructor throws crs_mismatch with the grid's name (PROJ 9.1 has no
// ONLY_BEST switch, so the list is inspected here).
class CrsConverter {
 public:
  // crs: of the outside data, x = easting or longitude, y = northing or latitude (GIS axis order).
  // z is passed through in metres when the CRS has no vertical part.
  CrsConverter(const std::string& crs, const LocalFrame& frame);
  ~CrsConverter();
  CrsConverter(CrsConverter&&) noexcept;
  CrsConverter& operator=(CrsConverter&&) noexcept;

  [[nodiscard]] geometry::Vec3 to_local(const geometry::Vec3& p_crs) const;
  [[nodiscard]] geometry::Vec3 from_local(const geometry::Vec3& p_world) const;
  // In place, many points.
  void to_local(std::vector<geometry::Vec3>& points) const;

  // Names of the operations used, for run.json.
  [[nodiscard]] const std::string& operation() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Geoid undulation [m] (ellipsoidal = orthometric + undulation) of a named geoid: "egm96".
// Throws crs_mismatch naming the grid file where it is not installed.
[[nodiscard]] double geoid_undulation(const std::string& geoid, const geometry::Geodetic& position);

}  // namespace cairn::geodesy
