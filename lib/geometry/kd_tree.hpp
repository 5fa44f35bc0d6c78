// Nearest neighbours among fixed points.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::geometry {

// Immutable index; queries may run from several threads. Build n log n, query about log n.
// Ties are broken by index, so results are deterministic.
class KdTree {
 public:
  // The points must outlive the tree.
  explicit KdTree(std::span<const Vec3> points);
  ~KdTree();
  KdTree(KdTree&&) noexcept;
  KdTree& operator=(KdTree&&) noexcept;

  struct Neighbour {
    std::size_t index = 0;
    double squared_distance = 0.0;  // m^2
  };
  // Up to k neighbours, nearest first.
  [[nodiscard]] std::vector<Neighbour> nearest(const Vec3& query, std::size_t k) const;
  // All within radius [m], nearest first.
  [[nodiscard]] std::vector<Neighbour> within(const Vec3& query, double radius) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::geometry
