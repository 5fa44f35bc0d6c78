#include "surface/sphere_field.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/parallel.hpp"

namespace cairn::surface {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr std::size_t kGrain = 4096;
// Fewer points than this many spread evenly over the reach make no plane: sum of weights on the surface.
constexpr double kLeastWeight = 2.0;
constexpr double kFullWeight = 4.0;

// Calls visit(node index, offset of the point from the node, squared distance / reach^2) for all nodes in reach.
template <typename Visit>
void each_node_in_reach(const Lattice& lattice, const Vec3& p, double reach, const Visit& visit) {
  const Vec3 local = (p - lattice.origin) / lattice.step;
  const double r = reach / lattice.step, r2 = r * r;
  const auto from = [&](int axis) {
    return std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(local[axis] - r)));
  };
  const auto to = [&](int axis) {
    return std::min(lattice.count[static_cast<std::size_t>(axis)] - 1,
                    static_cast<std::int64_t>(std::floor(local[axis] + r)));
  };
  for (std::int64_t k = from(2); k <= to(2); ++k) {
    const double z = local.z() - static_cast<double>(k);
    for (std::int64_t j = from(1); j <= to(1); ++j) {
      const double y = local.y() - static_cast<double>(j), yz = y * y + z * z;
      if (yz >= r2) continue;
      const double half = std::sqrt(r2 - yz);
      const auto first = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(local.x() - half)));
      const auto last = std::min(lattice.count[0] - 1, static_cast<std::int64_t>(std::floor(local.x() + half)));
      std::size_t n = lattice.index(first, j, k);
      for (std::int64_t i = first; i <= last; ++i, ++n) {
        const double x = local.x() - static_cast<double>(i);
        visit(n, lattice.step * x, lattice.step * y, lattice.step * z, std::min(1.0, (x * x + yz) / r2));
      }
    }
  }
}

struct PlaneSums {
  float w = 0, x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

struct SphereSums {
  float w = 0, p[3] = {0, 0, 0}, n[3] = {0, 0, 0}, pn = 0, pp = 0;
};

float weight(double share) {
  const double a = 1.0 - share;
  return static_cast<float>(a * a * a);
}

// Integral of the weights over a plane at distance d, per unit of point density.
double plane_weight(double d, double reach) {
  const double a = std::max(0.0, 1.0 - d * d / (reach * reach));
  return std::numbers::pi * reach * reach * a * a * a * a / 4.0;
}

}  // namespace

NodeBand nodes_in_reach(const Lattice& lattice, std::span<const Vec3> points, double reach) {
  NodeBand band;
  band.reach = reach;
  band.slot.assign(lattice.size(), -1);
  for (const auto& p : points)
    each_node_in_reach(lattice, p, reach, [&](std::size_t n, double, double, double, double) { band.slot[n] = 0; });
  for (std::size_t n = 0; n < band.slot.size(); ++n)
    if (band.slot[n] == 0) {
      band.slot[n] = static_cast<std::int32_t>(band.nodes.size());
      band.nodes.push_back(static_cast<std::uint32_t>(n));
    }
  return band;
}

NodeBand fit_planes(const Lattice& lattice, std::span<const Vec3> points, double reach) {
  NodeBand band = nodes_in_reach(lattice, points, reach);
  std::vector<PlaneSums> sums(band.nodes.size());
  for (const auto& p : points)
    each_node_in_reach(lattice, p, reach, [&](std::size_t n, double dx, double dy, double dz, double share) {
      auto& s = sums[static_cast<std::size_t>(band.slot[n])];
      const float w = weight(share), x = static_cast<float>(dx), y = static_cast<float>(dy), z = static_cast<float>(dz);
      s.w += w;
      s.x += w * x;
      s.y += w * y;
      s.z += w * z;
      s.xx += w * x * x;
      s.xy += w * x * y;
      s.xz += w * x * z;
      s.yy += w * y * y;
      s.yz += w * y * z;
      s.zz += w * z * z;
    });
  band.normal.assign(sums.size(), Vec3::Zero());
  band.distance.assign(sums.size(), 0.0F);
  band.point_area.assign(sums.size(), 0.0F);
  band.planar.assign(sums.size(), 0);
  base::parallel_for(sums.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    for (std::size_t b = begin; b < end; ++b) {
      const auto& s = sums[b];
      // Off the surface the weights fall: what follows asks for a node near it.
      if (!(static_cast<double>(s.w) > 0.3)) continue;
      const double w = static_cast<double>(s.w);
      const Vec3 mean = Vec3(static_cast<double>(s.x), static_cast<double>(s.y), static_cast<double>(s.z)) / w;
      Mat3 spread;
      spread << static_cast<double>(s.xx), static_cast<double>(s.xy), static_cast<double>(s.xz),
          static_cast<double>(s.xy), static_cast<double>(s.yy), static_cast<double>(s.yz), static_cast<double>(s.xz),
          static_cast<double>(s.yz), static_cast<double>(s.zz);
      spread = spread / w - mean * mean.transpose();
      solver.computeDirect(spread);
      const Vec3 normal = solver.eigenvectors().col(0);
      const double d = mean.dot(normal);
      if (std::abs(d) > 0.8 * reach || !normal.allFinite()) continue;
      const double on_surface = w * plane_weight(0.0, reach) / plane_weight(d, reach);
      if (on_surface < kLeastWeight) continue;
      // A line of points has no plane.
      const Vec3 values = solver.eigenvalues();
      if (!(values[1] > 0.02 * reach * reach * 0.25) || values[0] > 0.7 * values[1]) continue;
      band.normal[b] = normal;
      band.distance[b] = static_cast<float>(d);
      band.point_area[b] = static_cast<float>(plane_weight(d, reach) / w);
      band.planar[b] = 1;
    }
  });
  return band;
}

namespace {

// Of 26 straight ways from each node, those that leave the lattice without meeting a blocked node.
std::vector<std::uint8_t> count_free_ways(const Lattice& lattice, const std::vector<std::uint8_t>& blocked) {
  std::vector<std::uint8_t> ways(blocked.size(), 0);
  const auto [nx, ny, nz] = lattice.count;
  std::vector<std::array<int, 3>> directions;
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        if (x != 0 || y != 0 || z != 0) directions.push_back({x, y, z});
  std::vector<std::uint8_t> open(blocked.size());
  for (const auto& d : directions) {
    const auto step = static_cast<std::ptrdiff_t>((d[2] * ny + d[1]) * nx + d[0]);
    const auto row = [&](std::int64_t j, std::int64_t k) {
      const bool rim = j + d[1] < 0 || j + d[1] >= ny || k + d[2] < 0 || k + d[2] >= nz;
      const std::size_t first = lattice.index(0, j, k);
      const auto visit = [&](std::int64_t i) {
        const std::size_t n = first + static_cast<std::size_t>(i);
        const bool leaves = rim || i + d[0] < 0 || i + d[0] >= nx;
        const std::uint8_t is_open =
            blocked[n] == 0 && (leaves || open[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(n) + step)] != 0)
                ? 1
                : 0;
        open[n] = is_open;
        ways[n] = static_cast<std::uint8_t>(ways[n] + is_open);
      };
      if (d[0] > 0)
        for (std::int64_t i = nx - 1; i >= 0; --i) visit(i);
      else
        for (std::int64_t i = 0; i < nx; ++i) visit(i);
    };
    // The neighbour along the way is dealt with before the node itself.
    for (std::int64_t a = 0; a < nz; ++a) {
      const std::int64_t k = d[2] > 0 ? nz - 1 - a : a;
      for (std::int64_t b = 0; b < ny; ++b) row(d[1] > 0 ? ny - 1 - b : b, k);
    }
  }
  return ways;
}

}  // namespace

void orient(const Lattice& lattice, NodeBand& band, std::span<const Vec3> points, std::span<const Vec3> more) {
  // Walls of several nodes, so that no way slips through between samples.
  const double wall = 0.6 * band.reach;
  std::vector<std::uint8_t> blocked(lattice.size(), 0);
  const auto block = [&](std::span<const Vec3> list) {
    for (const auto& p : list)
      each_node_in_reach(lattice, p, wall, [&](std::size_t n, double, double, double, double) { blocked[n] = 1; });
  };
  block(points);
  block(more);
  const auto ways = count_free_ways(lattice, blocked);

  // Openness a little off the surface, beyond the wall.
  const auto openness = [&](const Vec3& at, const Vec3& way) {
    double sum = 0.0, count = 0.0;
    for (const double reach : {1.0, 1.35, 1.7}) {
      const Vec3 q = (at + reach * band.reach * way - lattice.origin) / lattice.step;
      std::array<std::int64_t, 3> c{};
      bool inside = true;
      for (int a = 0; a < 3; ++a) {
        const auto s = static_cast<std::size_t>(a);
        c[s] = static_cast<std::int64_t>(std::lround(q[a]));
        inside = inside && c[s] >= 0 && c[s] < lattice.count[s];
      }
      if (!inside) {
        sum += 26.0;
        count += 1.0;
        continue;
      }
      const std::size_t n = lattice.index(c[0], c[1], c[2]);
      if (blocked[n] != 0) continue;
      sum += static_cast<double>(ways[n]);
      count += 1.0;
    }
    return count > 0.0 ? sum / count : -1.0;
  };
  std::vector<float> vote(band.nodes.size(), 0.0F);
  base::parallel_for(band.nodes.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      if (band.planar[b] == 0) continue;
      const Vec3 on = lattice.node(band.nodes[b]) + static_cast<double>(band.distance[b]) * band.normal[b];
      const double front = openness(on, band.normal[b]), back = openness(on, -band.normal[b]);
      if (front < 0.0 || back < 0.0) continue;
      vote[b] = static_cast<float>((front - back) / 26.0);
    }
  });
  // Each node listens to the nodes around it, as far as their planes agree.
  constexpr int kRounds = 4;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<float> next(vote.size(), 0.0F);
    base::parallel_for(vote.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) {
        if (band.planar[b] == 0) continue;
        const auto c = lattice.cell_of(band.nodes[b]);
        double sum = 0.0;
        for (std::int64_t k = std::max<std::int64_t>(0, c[2] - 1); k <= std::min(lattice.count[2] - 1, c[2] + 1); ++k)
          for (std::int64_t j = std::max<std::int64_t>(0, c[1] - 1); j <= std::min(lattice.count[1] - 1, c[1] + 1); ++j)
            for (std::int64_t i = std::max<std::int64_t>(0, c[0] - 1); i <= std::min(lattice.count[0] - 1, c[0] + 1);
                 ++i) {
              const auto other = band.slot[lattice.index(i, j, k)];
              if (other < 0 || band.planar[static_cast<std::size_t>(other)] == 0) continue;
              const auto o = static_cast<std::size_t>(other);
              const double agree = band.normal[b].dot(band.normal[o]);
              sum += static_cast<double>(vote[o]) * agree * std::abs(agree);
            }
        next[b] = static_cast<float>(std::clamp(0.5 * sum, -1.0, 1.0));
      }
    });
    vote = std::move(next);
  }
  for (std::size_t b = 0; b < vote.size(); ++b) {
    if (band.planar[b] == 0) continue;
    if (vote[b] == 0.0F) band.planar[b] = 0;
    if (vote[b] < 0.0F) {
      band.normal[b] = -band.normal[b];
      band.distance[b] = -band.distance[b];
    }
  }
}

PointFrames point_frames(const Lattice& lattice, const NodeBand& band, std::span<const Vec3> points) {
  PointFrames frames;
  frames.normals.assign(points.size(), Vec3::Zero());
  frames.areas.assign(points.size(), 0.0);
  base::parallel_for(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 q = (points[i] - lattice.origin) / lattice.step;
      double total = 0.0;
      for (int corner = 0; corner < 8; ++corner) {
        double w = 1.0;
        std::array<std::int64_t, 3> c{};
        for (int a = 0; a < 3; ++a) {
          const auto s = static_cast<std::size_t>(a);
          const double low = std::floor(q[a]), f = q[a] - low;
          const bool upper = ((corner >> a) & 1) != 0;
          c[s] = std::clamp<std::int64_t>(static_cast<std::int64_t>(low) + (upper ? 1 : 0), 0, lattice.count[s] - 1);
          w *= upper ? f : 1.0 - f;
        }
        const auto slot = band.slot[lattice.index(c[0], c[1], c[2])];
        if (slot < 0 || band.planar[static_cast<std::size_t>(slot)] == 0) continue;
        const auto b = static_cast<std::size_t>(slot);
        frames.normals[i] += w * band.normal[b];
        frames.areas[i] += w * static_cast<double>(band.point_area[b]);
        total += w;
      }
      const double length = frames.normals[i].norm();
      if (!(total > 0.0) || !(length > 1e-3 * total)) {
        frames.normals[i].setZero();
        frames.areas[i] = 0.0;
        continue;
      }
      frames.normals[i] /= length;
      frames.areas[i] /= total;
    }
  });
  return frames;
}

std::vector<LocalSphere> fit_spheres(const Lattice& lattice, const NodeBand& band, std::span<const Vec3> points,
                                     std::span<const Vec3> normals) {
  std::vector<SphereSums> sums(band.nodes.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (normals[i].isZero()) continue;
    const float nx = static_cast<float>(normals[i].x()), ny = static_cast<float>(normals[i].y()),
                nz = static_cast<float>(normals[i].z());
    each_node_in_reach(lattice, points[i], band.reach,
                       [&](std::size_t n, double dx, double dy, double dz, double share) {
                         auto& s = sums[static_cast<std::size_t>(band.slot[n])];
                         const float w = weight(share), x = static_cast<float>(dx), y = static_cast<float>(dy),
                                     z = static_cast<float>(dz);
                         s.w += w;
                         s.p[0] += w * x;
                         s.p[1] += w * y;
                         s.p[2] += w * z;
                         s.n[0] += w * nx;
                         s.n[1] += w * ny;
                         s.n[2] += w * nz;
                         s.pn += w * (x * nx + y * ny + z * nz);
                         s.pp += w * (x * x + y * y + z * z);
                       });
  }
  std::vector<LocalSphere> spheres(sums.size());
  const double reach = band.reach;
  base::parallel_for(sums.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      const auto& s = sums[b];
      if (!(static_cast<double>(s.w) > 1e-3)) continue;
      const double w = static_cast<double>(s.w);
      const Vec3 p = Vec3(static_cast<double>(s.p[0]), static_cast<double>(s.p[1]), static_cast<double>(s.p[2])) / w;
      const Vec3 n = Vec3(static_cast<double>(s.n[0]), static_cast<double>(s.n[1]), static_cast<double>(s.n[2])) / w;
      if (n.norm() < 0.3) continue;  // sheets that face each other
      const double pp = static_cast<double>(s.pp) / w, spread = pp - p.squaredNorm();
      double u4 = 0.0;
      if (spread > 1e-4 * reach * reach) u4 = 0.5 * (static_cast<double>(s.pn) / w - p.dot(n)) / spread;
      // A fitted sphere smaller than the reach says nothing about the surface.
      u4 = std::clamp(u4, -0.5 * n.norm() / reach, 0.5 * n.norm() / reach);
      const Vec3 linear = n - 2.0 * u4 * p;
      const double u0 = -(linear.dot(p) + u4 * pp);
      const double discriminant = linear.squaredNorm() - 4.0 * u0 * u4;
      if (!(discriminant > 0.05)) continue;
      const double scale = 1.0 / std::sqrt(discriminant);
      auto& out = spheres[b];
      out.u0 = static_cast<float>(scale * u0);
      for (int a = 0; a < 3; ++a) out.linear[a] = static_cast<float>(scale * linear[a]);
      out.u4 = static_cast<float>(scale * u4);
      // How much stands on the surface below the node, and whether it lies on one side of it.
      const double d = std::min(std::abs(static_cast<double>(out.u0)), 0.95 * reach);
      const Vec3 unit = n.normalized();
      const double aside = (p - p.dot(unit) * unit).norm() / reach;
      const double on_surface = w * plane_weight(0.0, reach) / plane_weight(d, reach);
      const auto ramp = [](double t) {
        t = std::clamp(t, 0.0, 1.0);
        return t * t * (3.0 - 2.0 * t);
      };
      out.trust = static_cast<float>(ramp((on_surface - kLeastWeight) / (kFullWeight - kLeastWeight)) *
                                     ramp((0.5 - aside) / 0.2) * ramp((0.9 * reach - d) / (0.15 * reach)));
    }
  });
  return spheres;
}

}  // namespace cairn::surface
