#include <algorithm>
#include <array>
#include <cmath>

#include "surface/sphere_field.hpp"

namespace cairn::surface {
namespace {

using geometry::Vec3;

// Mean point and mean normal of each cell of `edge`, in order of cell; cells whose normals cancel are left out.
void thin(const Lattice& lattice, double edge, std::vector<Vec3>& points, std::vector<Vec3>& normals) {
  std::vector<std::pair<std::array<std::int32_t, 3>, std::size_t>> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 q = (points[i] - lattice.origin) / edge;
    order.push_back(
        {{static_cast<std::int32_t>(q.z()), static_cast<std::int32_t>(q.y()), static_cast<std::int32_t>(q.x())}, i});
  }
  std::sort(order.begin(), order.end());
  std::vector<Vec3> thinned, directions;
  for (std::size_t i = 0; i < order.size();) {
    Vec3 sum = Vec3::Zero(), normal = Vec3::Zero();
    std::size_t j = i;
    for (; j < order.size() && order[j].first == order[i].first; ++j) {
      sum += points[order[j].second];
      normal += normals[order[j].second];
    }
    const auto count = static_cast<double>(j - i);
    constexpr double kAgree = 0.5;
    if (normal.norm() > kAgree * count) {
      thinned.push_back(sum / count);
      directions.push_back(normal.normalized());
    }
    i = j;
  }
  points = std::move(thinned);
  normals = std::move(directions);
}

}  // namespace

WideField::WideField(const Lattice& lattice, double reach, double widest, std::span<const Vec3> points,
                     std::span<const Vec3> normals) {
  std::vector<Vec3> some, directions;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!normals[i].isZero()) {
      some.push_back(points[i]);
      directions.push_back(normals[i]);
    }
  Lattice level = lattice;
  for (reach *= 2.0; reach <= widest; reach *= 2.0) {
    for (auto& n : level.count) {
      if (n % 2 == 0) return;
      n = (n - 1) / 2 + 1;
      if (n < 3) return;
    }
    level.step *= 2.0;
    // Cells of the edge that makes the level's points as dense, in its steps, as the first level's are.
    thin(lattice, 0.625 * level.step, some, directions);
    Level next;
    next.lattice = level;
    next.band = nodes_in_reach(level, some, reach);
    next.spheres = fit_spheres(level, next.band, some, directions);
    levels_.push_back(std::move(next));
  }
}

double WideField::at(const Vec3& p, double otherwise) const {
  double value = 0.0, left = 1.0;
  for (const auto& level : levels_) {
    const Vec3 q = (p - level.lattice.origin) / level.lattice.step;
    double sum = 0.0, total = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
      double w = 1.0;
      std::array<std::int64_t, 3> c{};
      for (int a = 0; a < 3; ++a) {
        const auto s = static_cast<std::size_t>(a);
        const double low = std::floor(q[a]), f = q[a] - low;
        const bool upper = ((corner >> a) & 1) != 0;
        c[s] =
            std::clamp<std::int64_t>(static_cast<std::int64_t>(low) + (upper ? 1 : 0), 0, level.lattice.count[s] - 1);
        w *= upper ? f : 1.0 - f;
      }
      const auto slot = level.band.slot[level.lattice.index(c[0], c[1], c[2])];
      if (slot < 0) continue;
      const auto& sphere = level.spheres[static_cast<std::size_t>(slot)];
      w *= static_cast<double>(sphere.trust);
      sum += w * sphere.at(p - level.lattice.node(c[0], c[1], c[2]));
      total += w;
    }
    if (!(total > 0.0)) continue;
    value += left * sum;
    left *= 1.0 - std::min(1.0, total);
  }
  return value + left * otherwise;
}

}  // namespace cairn::surface
