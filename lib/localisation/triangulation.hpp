// One point from the centres of several boxes, with its own covariance.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "localisation/boxes.hpp"

namespace cairn::localisation {

// A sighting: the centre of a box in an ideal image and how far off it may be.
struct Sighting {
  const FrameView* frame = nullptr;
  geometry::Vec2 centre_px = geometry::Vec2::Zero();
  geometry::Vec2 sigma_px = geometry::Vec2::Ones();  // along u and v
  bool cut = false;                                  // centre of a cut box: never one of the pair to start from
};

struct TriangulationOptions {
  double gate = 3.5;      // sightings farther from the projected point [sigmas] are outliers
  std::size_t least = 2;  // consistent sightings that are not cut, at least 2
};

struct Triangulation {
  geometry::Vec3 centre = geometry::Vec3::Zero();      // local ENU, m
  geometry::Mat3 covariance = geometry::Mat3::Zero();  // of the centre: pixel and pose errors propagated, m^2
  std::vector<bool> inlier;                            // per sighting
  std::size_t inliers = 0;
  double rms_px = 0.0;        // of the inliers' residuals
  double parallax_rad = 0.0;  // largest angle between two inlier rays
};

// Where a point appears in a frame, and the covariance of that place from the point's own and the pose's [px^2].
struct Appearance {
  geometry::Vec2 pixel = geometry::Vec2::Zero();
  geometry::Mat2 covariance = geometry::Mat2::Zero();
  double depth_m = 0.0;
};

// Empty where the point lies behind the camera or nothing finite comes out.
[[nodiscard]] std::optional<Appearance> appearance(const FrameView& frame, const geometry::Vec3& point,
                                                   const geometry::Mat3& covariance);

// Squared distance [sigma^2] of a box centre with the given standard deviations; infinite where singular.
[[nodiscard]] double squared_distance(const Appearance& at, const geometry::Vec2& centre_px,
                                      const geometry::Vec2& sigma_px);

// Squared distance [sigma^2] between a sighting and the projection of a point with the given covariance
// (zero = the point is exact). Empty where the point lies behind the camera.
[[nodiscard]] std::optional<double> squared_distance(const Sighting& sighting, const geometry::Vec3& point,
                                                     const geometry::Mat3& covariance);

// Largest angle [rad] between two of the unit directions. Exact up to 64 of them; beyond, between the farthest found
// in four sweeps from the last farthest: exact on an arc, a little small at worst. Cost linear.
[[nodiscard]] double widest_angle(std::span<const geometry::Vec3> directions);

// Robust least squares in pixels. Start: of all pairs of sightings (at most 60 pairs of at most 64 sightings, spread
// evenly) the intersection that most sightings agree with, its own uncertainty allowed for; then Gauss-Newton with
// Huber's weights on those, twice re-selected by the gate. Each sighting's error is sigma_px plus the camera's position
// and rotation errors, taken as independent between frames. Empty where fewer than `least` agree, or the rays are so
// nearly parallel that the normal matrix is singular.
[[nodiscard]] std::optional<Triangulation> triangulate(std::span<const Sighting> sightings,
                                                       const TriangulationOptions& options);

// The same from a given start, without the search over pairs.
[[nodiscard]] std::optional<Triangulation> triangulate_from(const geometry::Vec3& start,
                                                            std::span<const Sighting> sightings,
                                                            const TriangulationOptions& options);

// Where two rays pass nearest, and how well two sightings alone fix that point.
struct Meeting {
  geometry::Vec3 point = geometry::Vec3::Zero();
  geometry::Mat3 covariance = geometry::Mat3::Zero();
};

// Empty for rays closer than 0.05 deg to parallel, and for points behind a camera.
[[nodiscard]] std::optional<Meeting> intersect(const Sighting& a, const Sighting& b);

}  // namespace cairn::localisation
