// The surface below a flight, as heights on a grid: how high a vehicle must stay.
#pragma once

#include <optional>
#include <vector>

#include "geometry/grid.hpp"
#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::planning {

// Highest point of the mesh in each cell, local up [m]; NaN where there is none. Upright faces count in every cell they
// touch. Never too low; too high by at most what a facet rises, in the cells of the facet's own box. cell [m] > 0;
// coarser where the grid would have more than `most_cells`. Cost: facets + cells.
[[nodiscard]] geometry::Grid<float> highest_of(const geometry::TriangleMesh& mesh, double cell,
                                               std::size_t most_cells = 16'000'000);

// Immutable; queries may run from several threads. Without a grid the surface is the plane at `level`.
class SurfaceHeights {
 public:
  explicit SurfaceHeights(double level);  // local up, m
  explicit SurfaceHeights(geometry::Grid<float> up);

  [[nodiscard]] bool is_plane() const { return plane_.has_value(); }
  // Local up at a point, m; empty where it is not known.
  [[nodiscard]] std::optional<double> up(const geometry::Vec2& p) const;
  // Highest known within `radius` [m] of the point or of the straight line between two; empty where nothing is known.
  [[nodiscard]] std::optional<double> highest(const geometry::Vec2& p, double radius) const;
  [[nodiscard]] std::optional<double> highest(const geometry::Vec2& a, const geometry::Vec2& b, double radius) const;
  // Fraction 0..1 of the known heights within `radius`, sorted; empty where nothing is known.
  [[nodiscard]] std::optional<double> quantile(const geometry::Vec2& p, double radius, double fraction) const;
  // Of all that is known.
  [[nodiscard]] double lowest() const { return lowest_; }
  [[nodiscard]] double highest() const { return highest_; }
  [[nodiscard]] double cell() const { return up_.geometry.cell; }

 private:
  // Calls take(height) for the known cells whose area comes within `radius` of the line.
  template <typename Take>
  void visit(const geometry::Vec2& a, const geometry::Vec2& b, double radius, Take&& take) const;

  std::optional<double> plane_;
  geometry::Grid<float> up_;
  double lowest_ = 0.0, highest_ = 0.0;
};

}  // namespace cairn::planning
