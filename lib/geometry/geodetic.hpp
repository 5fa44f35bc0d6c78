// A geographic position as plain data; conversions are in module `geodesy`.
#pragma once

namespace cairn::geometry {

// On WGS84. What the height is measured from is said by the owner.
struct Geodetic {
  double latitude_deg = 0.0;   // -90..90
  double longitude_deg = 0.0;  // -180..180
  double height_m = 0.0;

  friend bool operator==(const Geodetic&, const Geodetic&) = default;
};

}  // namespace cairn::geometry
