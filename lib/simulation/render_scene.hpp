// The world as cameras and scanners see it: surfaces with materials under a sun.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/rigid_transform.hpp"
#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"
#include "simulation/material.hpp"
#include "visibility/scene.hpp"

namespace cairn::simulation {

// Codes of the cloud's column `label`: those of docs/formats/clouds_and_meshes.md. What is neither ground nor rock
// (trees, cones) stays without a label.
enum class SurfacePart : std::uint8_t { other = 0, terrain = 1, rock = 2, pedestal = 3, basal_contact = 4 };

struct RenderBody {
  geometry::TriangleMesh mesh;  // world (local ENU), m; outward; colours (sRGB) are used where it has them
  Material material;
  SurfacePart part = SurfacePart::other;                 // never basal_contact: that is found from the rim
  std::int64_t object = -1;                              // ObjectId it belongs to, 0..65533; -1 = none
  std::vector<std::vector<geometry::Vec3>> contact_rim;  // of a rock, world
};

struct Lighting {
  double sun_azimuth_deg = 135.0;             // clockwise from north, where the sun stands
  double sun_elevation_deg = 42.0;            // 1..90
  double sun_strength = 1.0;                  // irradiance of sunlight at right angles, of what makes white 1
  Colour sun = Colour(1.0, 0.95, 0.86);       // its colour
  Colour ambient = Colour(0.30, 0.36, 0.46);  // light of the open sky on a level surface
  bool shadows = true;
  // Rays that find how open each vertex lies to the sky, 0..256; 0 = no darkening in hollows.
  std::int64_t openness_rays = 24;
  double openness_m = 1.5;  // their reach, m
  double haze_m = 2500.0;   // distance at which air hides two thirds of a surface, m
};

// Owns a copy of the surfaces, the ray-casting structure and what is computed once: normals and openness.
// Build: about 3 us a triangle and 0.1 us a vertex and openness ray on one core.
// Throws invalid_argument for an object beyond the range of a 16-bit mask, or a light out of range.
class RenderScene {
 public:
  RenderScene(std::vector<RenderBody> bodies, const Lighting& lighting);
  ~RenderScene();
  RenderScene(RenderScene&&) noexcept;
  RenderScene& operator=(RenderScene&&) noexcept;

  struct SurfacePoint {
    geometry::Vec3 position, normal;  // normal smoothed across gentle edges, unit, on the outer side
    geometry::Vec3 face_normal;       // of the triangle, unit
    const RenderBody* body = nullptr;
    std::size_t body_index = 0;
    double openness = 1.0;  // share of the sky's light that reaches it, 0..1
    Colour own_colour = Colour::Zero();
    bool has_colour = false;
  };
  // Point of a triangle of mesh() nearest along its plane to `position`.
  [[nodiscard]] SurfacePoint at(std::uint32_t triangle, const geometry::Vec3& position) const;
  // Light that leaves the point towards a camera at `distance` [m], linear, white = 1.
  [[nodiscard]] Colour shade(const SurfacePoint& point, double footprint, bool sunlit) const;
  [[nodiscard]] Colour through_air(const Colour& light, const geometry::Vec3& direction, double distance) const;
  [[nodiscard]] Colour sky(const geometry::Vec3& direction) const;

  [[nodiscard]] const geometry::TriangleMesh& mesh() const;  // all bodies, one after another
  [[nodiscard]] const visibility::Scene& rays() const;
  [[nodiscard]] std::span<const RenderBody> bodies() const;  // without their meshes
  [[nodiscard]] std::size_t body_of(std::uint32_t triangle) const;
  [[nodiscard]] const Lighting& lighting() const;
  [[nodiscard]] const geometry::Vec3& to_sun() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::simulation
