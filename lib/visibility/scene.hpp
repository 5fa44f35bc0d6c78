// Ray casting over a triangle surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"

namespace cairn::visibility {

inline constexpr std::uint32_t kNoTriangle = std::numeric_limits<std::uint32_t>::max();

struct Segment {
  geometry::Vec3 from = geometry::Vec3::Zero();  // local ENU, m
  geometry::Vec3 to = geometry::Vec3::Zero();
};

struct Hit {
  double distance = std::numeric_limits<double>::infinity();  // m along the unit direction
  std::uint32_t triangle = kNoTriangle;                       // index in the mesh given
  [[nodiscard]] bool hit() const { return triangle != kNoTriangle; }
};

// Immutable acceleration structure (Embree, single precision about the mesh's centre: error about
// 1e-7 of the extent). Degenerate and non-finite triangles are left out and counted. Queries may run
// from several threads; results do not depend on how rays are batched.
// Build: n log n, about 0.5 s and 100 bytes a triangle for 1 M triangles.
class Scene {
 public:
  explicit Scene(const geometry::TriangleMesh& mesh);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  [[nodiscard]] std::size_t skipped_triangles() const;

  // First hit of each ray (unit directions), out to max_distance [m].
  [[nodiscard]] std::vector<Hit> cast(std::span<const geometry::Ray> rays,
                                      double max_distance = std::numeric_limits<double>::infinity()) const;

  // Whether something blocks each segment; the last `end_gap` (fraction, 0..1) of it is not tested,
  // so that the surface under test does not block itself.
  [[nodiscard]] std::vector<std::uint8_t> blocked(std::span<const Segment> segments, double end_gap = 1e-4) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::visibility
