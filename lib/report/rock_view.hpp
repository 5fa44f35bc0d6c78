// A mesh seen from the side in parallel projection, shaded, as pixels.
#pragma once

#include <cstddef>

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"
#include "report/png.hpp"

namespace cairn::report {

// The camera looks level towards `azimuth_deg` (clockwise from +y); picture right is azimuth + 90, up is +z.
struct SideView {
  double azimuth_deg = 0.0;
  geometry::Vec3 right = geometry::Vec3::UnitX();  // unit
  geometry::Vec3 ahead = geometry::Vec3::UnitY();  // unit, away from the camera

  explicit SideView(double azimuth);
  // Right and up of a point, m.
  [[nodiscard]] geometry::Vec2 operator()(const geometry::Vec3& p) const { return {right.dot(p), p.z()}; }
};

struct ShadedView {
  RgbaImage image;                              // transparent where nothing is seen
  geometry::Vec2 low = geometry::Vec2::Zero();  // right, up of the picture's lower left corner, m
  double pixel_m = 0.01;                        // side of a pixel, m
};

// Nearest surface by a depth buffer, Lambert shading from the upper left of the camera; vertex colours where the mesh
// has them, else grey. The longer side of the picture has `longest_px` pixels. Cost linear in triangles and pixels.
[[nodiscard]] ShadedView shaded_view(const geometry::TriangleMesh& mesh, const SideView& view, std::size_t longest_px);

}  // namespace cairn::report
