// The survey's world: local east-north-up about its origin, and the two conversions cairn allows.
#pragma once

#include <memory>
#include <string>

#include "geometry/geodetic.hpp"
#include "geometry/vec.hpp"

namespace cairn::geodesy {

// East-north-up tangent frame on WGS84. Immutable, cheap to copy.
// Exact ellipsoidal conversions (GeographicLib::LocalCartesian); error below 1e-8 m within 1000 km.
class LocalFrame {
 public:
  // Throws crs_mismatch where latitude is outside -90..90, longitude outside -180..180, or a value is
  // not finite.
  explicit LocalFrame(const geometry::Geodetic& origin);

  [[nodiscard]] const geometry::Geodetic& origin() const noexcept { return origin_; }

  // Heights are above the ellipsoid in the geometry; whoever has another datum names it beside.
  [[nodiscard]] geometry::Vec3 to_local(const geometry::Geodetic& position) const;
  [[nodiscard]] geometry::Geodetic to_geodetic(const geometry::Vec3& p_world) const;

  // WKT2 of the rasters' CRS: transverse Mercator centred on the origin, scale set for the origin's
  // height, false easting and northing 0, so that (easting, northing) equal (east, north) to a
  // millimetre within a kilometre (design, section 3).
  [[nodiscard]] std::string raster_crs_wkt() const;

  // Identifies the frame in files; equal frames have equal fingerprints.
  [[nodiscard]] std::string fingerprint() const;

 private:
  geometry::Geodetic origin_;
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace cairn::geodesy
