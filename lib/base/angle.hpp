// An angle whose unit cannot be mistaken.
#pragma once

#include <cmath>
#include <compare>
#include <numbers>

namespace cairn::base {

class Angle {
 public:
  constexpr Angle() = default;
  [[nodiscard]] static constexpr Angle from_rad(double rad) { return Angle(rad); }
  [[nodiscard]] static constexpr Angle from_deg(double deg) { return Angle(deg * std::numbers::pi / 180.0); }

  [[nodiscard]] constexpr double rad() const { return rad_; }
  [[nodiscard]] constexpr double deg() const { return rad_ * 180.0 / std::numbers::pi; }

  friend constexpr Angle operator+(Angle a, Angle b) { return Angle(a.rad_ + b.rad_); }
  friend constexpr Angle operator-(Angle a, Angle b) { return Angle(a.rad_ - b.rad_); }
  friend constexpr Angle operator*(double s, Angle a) { return Angle(s * a.rad_); }
  friend constexpr auto operator<=>(Angle a, Angle b) = default;

 private:
  constexpr explicit Angle(double rad) : rad_(rad) {}
  double rad_ = 0.0;
};

[[nodiscard]] constexpr double deg_to_rad(double deg) {
  return deg * std::numbers::pi / 180.0;
}
[[nodiscard]] constexpr double rad_to_deg(double rad) {
  return rad * 180.0 / std::numbers::pi;
}

// Azimuth [deg, clockwise from north, 0 <= a < 360] of a horizontal direction (east, north).
[[nodiscard]] inline double azimuth_deg(double east, double north) {
  const double a = rad_to_deg(std::atan2(east, north));
  return a < 0.0 ? a + 360.0 : a;
}

}  // namespace cairn::base
