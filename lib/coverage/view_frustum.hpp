// What one view can hold: planes that settle most facets at once, the exact projection for the rest.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "coverage/view.hpp"
#include "geometry/vec.hpp"

namespace cairn::coverage {

// Rectangle of undistorted image coordinates (x/z, y/z).
struct ImageRectangle {
  double xmin = 0.0, xmax = 0.0, ymin = 0.0, ymax = 0.0;
  [[nodiscard]] bool contains(double x, double y) const { return x >= xmin && x <= xmax && y >= ymin && y <= ymax; }
};

// Per camera, shared by its views.
struct CameraBounds {
  survey::Camera camera;
  double margin = 0.0;   // fraction of width and height kept free at the border
  bool bounded = false;  // whether `outer` holds: false for fields of view of half a turn and more
  bool exact = false;    // outer = inner = the frame: no distortion
  ImageRectangle outer;  // every point inside the frame lies in it
  ImageRectangle inner;  // every point in it lies inside the frame; empty (xmin > xmax) where unknown

  // Pixels per unit of undistorted image area, divided by fx fy: 1 without distortion.
  [[nodiscard]] double magnification(double x, double y) const;

  // Table of the above over `outer`; empty without distortion.
  std::vector<double> table;
};

// margin: 0 <= margin < 0.5. Throws invalid_input for a camera without size or focal length.
[[nodiscard]] CameraBounds camera_bounds(const survey::Camera& camera, double margin);

// One view in the world.
struct ViewFrustum {
  const CameraBounds* bounds = nullptr;
  geometry::Vec3 centre = geometry::Vec3::Zero();
  geometry::Mat3 R_camera_world = geometry::Mat3::Identity();
  // Inward normals of the planes through the centre; plane . (p - centre) >= 0 inside.
  // The fifth is the viewing direction. All zero (nothing culled but what lies behind) where unbounded.
  std::array<geometry::Vec3, 5> outer;
  std::array<geometry::Vec3, 5> inner;
  bool has_inner = false;

  // Inside the frame with its margin, distortion honoured.
  [[nodiscard]] bool sees(const geometry::Vec3& p_world) const;
};

[[nodiscard]] ViewFrustum view_frustum(const CameraBounds& bounds, const geometry::RigidTransform& T_world_camera);

}  // namespace cairn::coverage
