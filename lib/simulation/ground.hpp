// The ground of a scene: its surface, and heights on it.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "simulation/scene.hpp"
#include "visibility/scene.hpp"

namespace cairn::simulation {

// Surface of a terrain, facing up. Fractal: a regular grid of vertices, each cell cut along its flatter diagonal.
[[nodiscard]] geometry::TriangleMesh terrain_mesh(const Terrain& terrain);

// Heights by ray casting from above (error about 2e-7 of the extent).
class Ground {
 public:
  explicit Ground(const geometry::TriangleMesh& mesh);

  // m, local up; NaN where there is no ground.
  [[nodiscard]] std::vector<double> heights(std::span<const geometry::Vec2> places) const;
  [[nodiscard]] std::optional<double> height(const geometry::Vec2& place) const;
  // Unit normal of the ground, upwards; empty where there is none.
  [[nodiscard]] std::optional<geometry::Vec3> normal(const geometry::Vec2& place) const;
  // Mean over the vertices of the ground inside the ring; over all where none lies inside.
  [[nodiscard]] double mean_height(const geometry::Ring& area) const;
  [[nodiscard]] const geometry::Box3& bounds() const { return bounds_; }

 private:
  const geometry::TriangleMesh* mesh_;
  geometry::Box3 bounds_;
  visibility::Scene scene_;
};

}  // namespace cairn::simulation
