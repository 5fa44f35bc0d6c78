#include "surface/implicit_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

#include "base/parallel.hpp"
#include "geometry/kd_tree.hpp"
#include "surface/march.hpp"
#include "surface/poisson_grid.hpp"
#include "surface/sphere_field.hpp"

namespace cairn::surface {
namespace {

using geometry::Box3;
using geometry::Vec3;

constexpr std::size_t kGrain = 16384;

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

bool less_by_position(const Vec3& a, const Vec3& b) {
  return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
}

// Sorted by cells of `edge`, then by position; duplicates gone; clusters of cells that touch by a corner and hold
// less than a twentieth of the points left out.
std::vector<Vec3> tidy(std::span<const Vec3> points, double edge, std::size_t& stray) {
  Box3 box;
  for (const auto& p : points) box.extend(p);
  using Cell = std::array<std::int32_t, 3>;
  struct Entry {
    Cell cell;
    Vec3 p;
  };
  std::vector<Entry> entries;
  entries.reserve(points.size());
  for (const auto& p : points) {
    const Vec3 q = (p - box.min) / edge;
    entries.push_back(
        {{static_cast<std::int32_t>(q.z()), static_cast<std::int32_t>(q.y()), static_cast<std::int32_t>(q.x())}, p});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return a.cell != b.cell ? a.cell < b.cell : less_by_position(a.p, b.p);
  });
  entries.erase(std::unique(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.p == b.p; }),
                entries.end());
  std::vector<Cell> cells;
  std::vector<std::size_t> first;
  for (std::size_t i = 0; i < entries.size(); ++i)
    if (cells.empty() || entries[i].cell != cells.back()) {
      cells.push_back(entries[i].cell);
      first.push_back(i);
    }
  first.push_back(entries.size());
  std::vector<std::uint32_t> parent(cells.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::uint32_t i = 0; i < cells.size(); ++i)
    for (std::int32_t dz = -1; dz <= 1; ++dz)
      for (std::int32_t dy = -1; dy <= 1; ++dy) {
        // The three cells of a row stand together.
        const Cell low{cells[i][0] + dz, cells[i][1] + dy, cells[i][2] - 1};
        for (auto it = std::lower_bound(cells.begin(), cells.end(), low);
             it != cells.end() && (*it)[0] == low[0] && (*it)[1] == low[1] && (*it)[2] <= low[2] + 2; ++it) {
          const auto a = root(i), b = root(static_cast<std::uint32_t>(it - cells.begin()));
          parent[std::max(a, b)] = std::min(a, b);
        }
      }
  std::vector<std::size_t> members(cells.size(), 0);
  for (std::uint32_t i = 0; i < cells.size(); ++i) members[root(i)] += first[i + 1] - first[i];
  constexpr double kLeastShare = 0.05;
  std::vector<Vec3> kept;
  kept.reserve(entries.size());
  for (std::uint32_t i = 0; i < cells.size(); ++i) {
    if (static_cast<double>(members[root(i)]) < kLeastShare * static_cast<double>(entries.size())) continue;
    for (std::size_t k = first[i]; k < first[i + 1]; ++k) kept.push_back(entries[k].p);
  }
  stray = entries.size() - kept.size();
  return kept;
}

// Fine lattice around the box whose every second node makes one that the Poisson solver takes.
std::pair<Lattice, Lattice> lattices(const Box3& box, double step) {
  constexpr double kMargin = 5.0;  // coarse cells on every side
  Lattice coarse, fine;
  coarse.step = 2.0 * step;
  fine.step = step;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    coarse.count[a] = poisson_count(box.size()[axis] + 2.0 * kMargin * coarse.step, coarse.step);
    fine.count[a] = 2 * (coarse.count[a] - 1) + 1;
    const double extent = static_cast<double>(coarse.count[a] - 1) * coarse.step;
    coarse.origin[axis] = fine.origin[axis] = box.centre()[axis] - 0.5 * extent;
  }
  return {coarse, fine};
}

double ramp(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

// Length of the indicator's gradient over four cells, 1/m; no less than a fall over forty cells, for the division.
double slope_of(const Lattice& lattice, std::span<const float> values, const Vec3& p) {
  Vec3 gradient;
  for (Eigen::Index a = 0; a < 3; ++a) {
    const Vec3 way = 2.0 * lattice.step * Vec3::Unit(a);
    gradient[a] =
        (interpolate(lattice, values, p + way) - interpolate(lattice, values, p - way)) / (4.0 * lattice.step);
  }
  return std::max(gradient.norm(), 0.025 / lattice.step);
}

// The rock's values and the cap's, whose larger one counts; the cap's apart so that the crease between them stays
// sharp.
struct Fields {
  std::vector<float> rock, cap, value;
};

constexpr float kNoCap = -1e30F;

void lay_caps(const Lattice& lattice, std::span<const CapPatch> caps, Fields& fields) {
  const double h = lattice.step;
  for (const auto& cap : caps) {
    // Beyond the outline the cap is felt for a few cells only.
    const double beside = 3.0 * h, above = 3.0 * h;
    base::parallel_for(static_cast<std::size_t>(lattice.count[2]), 2, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k)
        for (std::int64_t j = 0; j < lattice.count[1]; ++j)
          for (std::int64_t i = 0; i < lattice.count[0]; ++i) {
            const std::size_t n = lattice.index(i, j, static_cast<std::int64_t>(k));
            double depth = 0.0;
            const double below = cap.below(lattice.node(n), depth);
            if (below < -above || depth < -beside) continue;
            if (depth < 0.0 && below > beside) continue;
            // Well inside the outline the cap alone bounds the rock from below.
            const double give_way = 2.0 * std::max(0.0, depth - h) * ramp((below + above) / (0.5 * above));
            fields.rock[n] -= static_cast<float>(give_way);
            fields.cap[n] = std::max(fields.cap[n], static_cast<float>(below));
          }
    });
  }
}

}  // namespace

double surface_spacing(std::span<const Vec3> points) {
  constexpr std::size_t kNeighbours = 8, kSample = 2000;
  if (points.size() <= kNeighbours) return 0.0;
  const geometry::KdTree tree(points);
  const std::size_t stride = std::max<std::size_t>(1, points.size() / kSample);
  std::vector<double> spacing;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const auto near = tree.nearest(points[i], kNeighbours + 1);
    spacing.push_back(std::sqrt(std::numbers::pi * near.back().squared_distance / static_cast<double>(kNeighbours)));
  }
  const auto at = spacing.begin() + static_cast<std::ptrdiff_t>(7 * spacing.size() / 10);
  std::nth_element(spacing.begin(), at, spacing.end());
  return *at;
}

ImplicitSurface implicit_surface(std::span<const Vec3> points, std::span<const CapPatch> caps, double spacing,
                                 const ImplicitSettings& settings) {
  ImplicitSurface result;
  result.spacing = spacing;
  if (!(spacing > 0.0)) return result;
  const auto cloud = tidy(points, 5.0 * spacing, result.stray_points);
  Box3 box;
  for (const auto& p : cloud) box.extend(p);
  for (const auto& cap : caps) {
    box.extend(cap.bounds().min);
    box.extend(cap.bounds().max);
  }
  double step = settings.step_factor * spacing;
  auto [coarse, lattice] = lattices(box, step);
  while (lattice.size() > settings.max_nodes) {
    step *= 1.1;
    std::tie(coarse, lattice) = lattices(box, step);
  }
  result.step = step;
  const double reach = settings.reach_factor * step;

  std::vector<Vec3> cap_points;
  std::vector<Vec3> cap_normals;
  std::vector<double> cap_areas;
  for (const auto& cap : caps) {
    const auto samples = cap.samples();
    const double area = samples.empty() ? 0.0 : cap.area() / static_cast<double>(samples.size());
    cap_points.insert(cap_points.end(), samples.begin(), samples.end());
    cap_normals.insert(cap_normals.end(), samples.size(), -cap.normal());
    cap_areas.insert(cap_areas.end(), samples.size(), area);
  }
  auto band = fit_planes(lattice, cloud, reach);
  orient(lattice, band, cloud, cap_points);
  auto frames = point_frames(lattice, band, cloud);
  for (const auto& n : frames.normals)
    if (n.isZero()) ++result.stray_points;
  const auto spheres = fit_spheres(lattice, band, cloud, frames.normals);

  // A lone point must not stand for more surface than it can see.
  const double most = 9.0 * spacing * spacing;
  for (auto& a : frames.areas) a = std::min(a, most);
  std::vector<Vec3> all = cloud, normals = frames.normals;
  all.insert(all.end(), cap_points.begin(), cap_points.end());
  normals.insert(normals.end(), cap_normals.begin(), cap_normals.end());
  auto areas = frames.areas;
  areas.insert(areas.end(), cap_areas.begin(), cap_areas.end());
  const auto indicator = solve_poisson(coarse, all, normals, areas);
  std::vector<double> levels;
  for (std::size_t i = 0; i < cloud.size(); ++i)
    if (!frames.normals[i].isZero()) levels.push_back(interpolate(coarse, indicator, cloud[i]));
  if (levels.empty()) return result;
  const double level = median_of(std::move(levels));

  // A bridge may be half as wide as the rock.
  const double thickness = box.size().minCoeff();
  const WideField wide(lattice, reach, 0.5 * thickness, cloud, frames.normals);
  Fields fields;
  fields.rock.resize(lattice.size());
  fields.cap.assign(lattice.size(), kNoCap);
  base::parallel_for(lattice.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t n = begin; n < end; ++n) {
      const double inside = interpolate(coarse, indicator, lattice.node(n)) - level;
      const double far = std::clamp(-inside * 1.5 * coarse.step, -2.0 * step, 2.0 * step);
      const auto slot = band.slot[n];
      const auto* sphere = slot < 0 ? nullptr : &spheres[static_cast<std::size_t>(slot)];
      const double trust = sphere == nullptr ? 0.0 : static_cast<double>(sphere->trust);
      double value = far;
      // Where the indicator is undecided the points leave a gap: wider fits carry its surroundings' curvature across.
      constexpr double kDecided = 0.4, kUndecided = 0.3;
      const double open = ramp((kDecided - std::abs(inside)) / (kDecided - kUndecided));
      if (trust < 1.0 && open > 0.0) {
        // The indicator bridges flat, the wide fits as round as the rest is. Rocks are in between; but a gap as wide as
        // the rock itself is its other side. Across a round gap the indicator's slope is 1 / diameter.
        const double slope = slope_of(coarse, indicator, lattice.node(n));
        const double round = 0.5 + 0.5 * ramp((1.0 / (slope * thickness) - 0.4) / 0.3);
        const double bridged = round * wide.at(lattice.node(n), -inside / slope) - (1.0 - round) * inside / slope;
        value = (1.0 - open) * far + open * std::clamp(bridged, -2.0 * step, 2.0 * step);
      }
      if (sphere != nullptr) value = (1.0 - trust) * value + trust * static_cast<double>(sphere->u0);
      fields.rock[n] = static_cast<float>(value);
    }
  });

  // Residuals by the fit at the nearest node.
  std::vector<double> residuals;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (frames.normals[i].isZero()) continue;
    const Vec3 q = (cloud[i] - lattice.origin) / step;
    const std::size_t n = lattice.index(std::lround(q.x()), std::lround(q.y()), std::lround(q.z()));
    const auto slot = band.slot[n];
    if (slot < 0 || spheres[static_cast<std::size_t>(slot)].trust < 0.5F) continue;
    residuals.push_back(std::abs(spheres[static_cast<std::size_t>(slot)].at(cloud[i] - lattice.node(n))));
  }
  if (residuals.empty()) return result;
  constexpr double kSigmaOfMedian = 1.4826;
  result.noise = kSigmaOfMedian * median_of(std::move(residuals));

  lay_caps(lattice, caps, fields);
  fields.value.resize(lattice.size());
  for (std::size_t n = 0; n < fields.value.size(); ++n) fields.value[n] = std::max(fields.rock[n], fields.cap[n]);
  // The boundary is outside, whatever stray points say.
  for (std::size_t n = 0; n < fields.value.size(); ++n) {
    const auto c = lattice.cell_of(n);
    for (std::size_t a = 0; a < 3; ++a)
      if (c[a] == 0 || c[a] == lattice.count[a] - 1) fields.value[n] = fields.rock[n] = static_cast<float>(step);
  }

  const auto sphere_at = [&](std::size_t n) -> const LocalSphere* {
    const auto slot = band.slot[n];
    if (slot < 0) return nullptr;
    const auto& sphere = spheres[static_cast<std::size_t>(slot)];
    constexpr float kFull = 0.99F;
    return sphere.trust > kFull ? &sphere : nullptr;
  };
  const Crossing crossing = [&](std::size_t inner, std::size_t outer) {
    const auto linear = [](double a, double b) { return a / (a - b); };
    double share = 1.0;
    const double a = static_cast<double>(fields.rock[inner]), b = static_cast<double>(fields.rock[outer]);
    if (b >= 0.0) {
      share = linear(a, b);
      const auto *in = sphere_at(inner), *out = sphere_at(outer);
      const bool bare = fields.cap[inner] == kNoCap && fields.cap[outer] == kNoCap;
      if (in != nullptr && out != nullptr && bare) {
        // The two spheres, blended along the edge: its curvature counts too.
        const Vec3 way = lattice.node(outer) - lattice.node(inner);
        const auto value = [&](double t) { return (1.0 - t) * in->at(t * way) + t * out->at((t - 1.0) * way); };
        double lo = 0.0, hi = 1.0;
        double at_lo = a, at_hi = b;
        for (int round = 0; round < 4; ++round) {
          const double v = value(share);
          if (v < 0.0) lo = share, at_lo = v;
          else hi = share, at_hi = v;
          share = lo + (hi - lo) * linear(at_lo, at_hi);
        }
      }
    }
    if (const float cap_out = fields.cap[outer]; cap_out >= 0.0F) {
      const float cap_in = std::max(fields.cap[inner], static_cast<float>(-3.0 * step));
      share = std::min(share, linear(static_cast<double>(cap_in), static_cast<double>(cap_out)));
    }
    return share;
  };
  result.surface.mesh = largest_piece(march_tetrahedra(lattice, fields.value, crossing), result.pieces_dropped);

  const auto& mesh = result.surface.mesh;
  result.surface.seen.assign(mesh.triangles.size(), 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 p = mesh.centroid(t), q = (p - lattice.origin) / lattice.step;
    bool capped = false;
    for (const auto& cap : caps) {
      double depth = 0.0;
      const double below = cap.below(p, depth);
      capped = capped || (depth > 0.0 && below > -0.5 * step);
    }
    if (capped) continue;
    const std::size_t n = lattice.index(std::lround(q.x()), std::lround(q.y()), std::lround(q.z()));
    const auto slot = band.slot[n];
    if (slot >= 0 && spheres[static_cast<std::size_t>(slot)].trust > 0.5F) result.surface.seen[t] = 1;
  }
  return result;
}

}  // namespace cairn::surface
