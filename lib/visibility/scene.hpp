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

// watertight: no ray slips between two triangles that share an edge.
// fast: Embree's default, about 20 % less time; a ray that grazes an edge to within single precision may slip
// through. Against double precision both err equally often on grazing rays (a millionth of the sight lines of a
// rough terrain). Rays blocked and not blocked are the same as those of a plain rtcOccluded1 loop.
enum class Tracing { watertight, fast };

// Immutable acceleration structure (Embree 3, single precision about the mesh's centre: error about
// 2e-7 of the extent). Triangles are seen from both sides. Triangles with two
// equal indices, zero area, an index beyond the vertices, or a vertex that is not finite or farther
// than 1e8 m from the origin are left out and counted. Queries may run from several threads; results do
// not depend on how rays are batched, on threads, or on the order of the triangles (of two triangles hit
// at the same distance the lower index is reported).
// Build: n log n, about 0.5 CPU s and 150 bytes a triangle for 1 M triangles.
// Throws resource_exhausted where Embree cannot reserve its memory.
class Scene {
 public:
  explicit Scene(const geometry::TriangleMesh& mesh, Tracing tracing = Tracing::watertight);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  [[nodiscard]] std::size_t skipped_triangles() const;

  // First hit of each ray (unit directions), out to max_distance [m]. Rays that are not finite hit nothing.
  // Neighbouring rays should be similar (same origin, close directions): they are traced 16 at a time.
  [[nodiscard]] std::vector<Hit> cast(std::span<const geometry::Ray> rays,
                                      double max_distance = std::numeric_limits<double>::infinity()) const;

  // 1 where something blocks the segment; the last `end_gap` (fraction, 0..1) of it is not tested,
  // so that the surface under test does not block itself. A segment that is not finite is blocked, one of
  // zero length is not.
  [[nodiscard]] std::vector<std::uint8_t> blocked(std::span<const Segment> segments, double end_gap = 1e-4) const;

  // The same for segments with one common start, without allocation: blocked[i] for from -> to[i].
  // Sizes must be equal.
  void blocked_from(const geometry::Vec3& from, std::span<const geometry::Vec3> to, std::span<std::uint8_t> blocked,
                    double end_gap = 1e-4) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::visibility
