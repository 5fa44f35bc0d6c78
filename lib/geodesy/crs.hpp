// Coordinate reference systems, by PROJ. Never uses the network.
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
  std::string authority_code;      // "EPSG:32615", "EPSG:2227+6360", or ""
  bool geographic = false;         // axes are angles
  bool has_vertical = false;       // compound or 3-D
  double horizontal_unit_m = 1.0;  // length of one horizontal unit; radians per unit when geographic
  double vertical_unit_m = 1.0;    // of the vertical axis where there is one
  bool vertical_is_depth = false;  // the vertical axis points down
};

// Accepts "EPSG:n", "EPSG:n+m" (horizontal + vertical), WKT 1 or 2, PROJ strings with +type=crs. Throws
// crs_mismatch with the text where PROJ cannot read it, or where it is not a CRS of the Earth's surface.
[[nodiscard]] CrsInfo describe_crs(const std::string& crs);

// The same CRS as one line of WKT2:2019 (files carry it), with the same checks.
[[nodiscard]] std::string crs_wkt(const std::string& crs);

// What becomes of heights.
enum class Heights {
  to_ellipsoid,  // converted to heights above the WGS84 ellipsoid; needs the geoid's grid
  keep_datum,    // only the unit and direction become metres up; the vertical datum stays what it was,
                 // and the survey's height type has to name it
};

struct CrsOptions {
  Heights heights = Heights::to_ellipsoid;
  // Where the grid of PROJ's best operation is not installed, take the best operation that is (never
  // a "ballpark" one, which drops the datum). Off: that is an error. operation() tells the accuracy.
  bool accept_coarser = false;
};

// Converts between a CRS and the local frame. Only the best operation of PROJ's list for the frame's
// place is taken; where its grid is absent the constructor throws crs_mismatch with the grid's name
// (PROJ 9.1 has no ONLY_BEST switch, so the list is inspected here).
//
// Units: everything becomes metres. A CRS without a vertical part passes z as metres, unless its
// horizontal unit is another one (feet): nobody can tell then what z is in, so that is crs_mismatch.
//
// Threads: one object may be used from several threads; calls take turns.
class CrsConverter {
 public:
  // crs: of the outside data, x = easting or longitude, y = northing or latitude (GIS axis order).
  CrsConverter(const std::string& crs, const LocalFrame& frame, const CrsOptions& options = {});
  ~CrsConverter();
  CrsConverter(CrsConverter&&) noexcept;
  CrsConverter& operator=(CrsConverter&&) noexcept;

  // Each throws crs_mismatch with the point where it is not finite or lies outside the CRS.
  // Accuracy of the round trip: 1e-6 m for projected CRSs near their area of use.
  [[nodiscard]] geometry::Vec3 to_local(const geometry::Vec3& p_crs) const;
  [[nodiscard]] geometry::Vec3 from_local(const geometry::Vec3& p_world) const;
  // In place, many points. Cost: about 1 us a point.
  void to_local(std::vector<geometry::Vec3>& points) const;
  void from_local(std::vector<geometry::Vec3>& points) const;

  // Operation used, its accuracy and its grids, for run.json.
  [[nodiscard]] const std::string& operation() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Geoid undulation N [m] (ellipsoidal = orthometric + N) of a named geoid: "egm96" (15' grid, bilinear,
// within 1 m of the spherical harmonics). At 48.21 N 16.41 E it is +44.71 m.
// Throws crs_mismatch naming the grid file where it is not installed, and for an unknown geoid.
[[nodiscard]] double geoid_undulation(const std::string& geoid, const geometry::Geodetic& position);

}  // namespace cairn::geodesy
