// How well an estimated upright cylinder holds the object it stands for.
#pragma once

#include <optional>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/truth.hpp"

namespace cairn::evaluation {

[[nodiscard]] double volume(const geometry::VerticalCylinder& cylinder);  // m^3
// Area that two circles share, m^2.
[[nodiscard]] double circle_intersection(const geometry::Vec2& a, double radius_a, const geometry::Vec2& b,
                                         double radius_b);
// Volume of the intersection over volume of the union, 0..1; exact. 0 where both are empty.
[[nodiscard]] double iou(const geometry::VerticalCylinder& a, const geometry::VerticalCylinder& b);

// A piece of surface, small enough to stand for a point.
struct SurfacePatch {
  geometry::Vec3 centre = geometry::Vec3::Zero();  // local ENU, m
  double area_m2 = 0.0;
};

// The exposed surface of an object as patches: its mesh (local ENU, triangles outwards) cut into triangles with edges
// of at most step_m (> 0), less what lies below the true cylinder's bottom (buried) and less the contact: downward
// patches inside a contact rim's plan, not above the rim. Cost: area / step_m^2.
[[nodiscard]] std::vector<SurfacePatch> exposed_surface(const geometry::TriangleMesh& mesh,
                                                        const survey::TruthObject& object, double step_m = 0.05);

// Share of the area whose patches lie inside or on the cylinder, 0..1. Empty where there is no area.
[[nodiscard]] std::optional<double> contained_share(const std::vector<SurfacePatch>& surface,
                                                    const geometry::VerticalCylinder& cylinder);

}  // namespace cairn::evaluation
