// A small shaded picture of a rock from the side.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "report/png.hpp"

namespace cairn::report {

// Palette indices above this are of facets closed by the cap model; 0 is transparent.
inline constexpr std::uint8_t kSeenColours = 40;

// Orthographic, the optical axis level. Pixel (x, y) shows right = left_m + x * m_per_px along the picture's right,
// up = top_m - y * m_per_px (both measured in the mesh's own frame).
struct RockPicture {
  IndexedImage image;  // transparent round the rock
  double left_m = 0.0, top_m = 0.0, m_per_px = 1.0;
  geometry::Vec3 right = geometry::Vec3::UnitX();  // level unit vector

  [[nodiscard]] geometry::Vec2 pixel(const geometry::Vec3& p) const {
    return {(p.dot(right) - left_m) / m_per_px, (top_m - p.z()) / m_per_px};
  }
};

// right_azimuth_deg: what lies to the right, clockwise from north: the direction of toppling, so that the rock falls to
// the right. width_px, height_px: of the picture; the rock fills it but for margin_px. facet_seen: 0 = closed by the
// cap model (drawn in another tint); empty = all seen. An empty mesh gives a transparent picture. Cost: linear in
// triangles and pixels covered.
[[nodiscard]] RockPicture draw_rock(const geometry::TriangleMesh& mesh, const std::vector<std::uint8_t>& facet_seen,
                                    double right_azimuth_deg, std::size_t width_px, std::size_t height_px,
                                    std::size_t margin_px);

}  // namespace cairn::report
