#include "segmentation/touching.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/enclosing_circle.hpp"
#include "geometry/grid.hpp"
#include "geometry/primitives.hpp"
#include "segmentation/grid_fill.hpp"
#include "segmentation/patch_graph.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;
using geometry::GridGeometry;
using geometry::Vec2;
using geometry::Vec3;

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kLeastCells = 8;      // of a basin that may stay apart
constexpr std::size_t kMostCells = 40'000;  // of the heights: coarser beyond
constexpr int kFillRounds = 2;
constexpr float kFillNeighbours = 4.0F;
constexpr float kEmpty = -std::numeric_limits<float>::infinity();

template <class Visit>
void for_neighbours(const GridGeometry& g, std::size_t k, Visit visit) {
  const std::size_t r = k / g.columns, c = k % g.columns;
  for (std::size_t i = r - (r > 0 ? 1U : 0U); i <= std::min(r + 1, g.rows - 1); ++i)
    for (std::size_t j = c - (c > 0 ? 1U : 0U); j <= std::min(c + 1, g.columns - 1); ++j)
      if (i != r || j != c) visit(i * g.columns + j);
}

// Highest point above the ground in each cell, then the median with its neighbours against lone high points.
Grid<float> top_heights(const Candidate& candidate, std::span<const Vec3> points, const GroundFilterResult& ground,
                        double cell) {
  Vec2 low = points[candidate.points.front()].head<2>(), high = low;
  for (const auto i : candidate.points) {
    low = low.cwiseMin(points[i].head<2>());
    high = high.cwiseMax(points[i].head<2>());
  }
  GridGeometry g;
  g.west = low.x(), g.north = high.y(), g.cell = cell;
  g.columns = static_cast<std::size_t>((high.x() - low.x()) / cell) + 1;
  g.rows = static_cast<std::size_t>((high.y() - low.y()) / cell) + 1;
  Grid<float> raw(g, kEmpty);
  for (const auto i : candidate.points) {
    float& top = raw.values[clamped_cell(g, points[i].head<2>())];
    top = std::max(top, static_cast<float>(ground.surface.height_above(points[i])));
  }
  for (int round = 0; round < kFillRounds; ++round) {  // gaps of a cell or two are no valleys
    const Grid<float> before = raw;
    for (std::size_t k = 0; k < raw.values.size(); ++k) {
      if (before.values[k] != kEmpty) continue;
      float sum = 0.0F, count = 0.0F;
      for_neighbours(g, k, [&](std::size_t n) {
        if (before.values[n] != kEmpty) sum += before.values[n], ++count;
      });
      if (count >= kFillNeighbours) raw.values[k] = sum / count;
    }
  }
  Grid<float> smooth = raw;
  for (std::size_t k = 0; k < raw.values.size(); ++k) {
    if (raw.values[k] == kEmpty) continue;
    std::array<float, 9> near{};
    std::size_t count = 0;
    near[count++] = raw.values[k];
    for_neighbours(g, k, [&](std::size_t n) {
      if (raw.values[n] != kEmpty) near[count++] = raw.values[n];
    });
    const auto middle = near.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(near.begin(), middle, near.begin() + static_cast<std::ptrdiff_t>(count));
    smooth.values[k] = *middle;
  }
  return smooth;
}

struct Basins {
  std::vector<std::uint32_t> parent;  // one a basin
  std::vector<float> top;             // height above the ground, m
  std::vector<std::size_t> cells;

  std::uint32_t root(std::uint32_t b) const {
    while (parent[b] != b) b = parent[b];
    return b;
  }
};

struct Flooded {
  std::vector<std::uint32_t> basin;  // of each cell; kNone where there is no height
  std::vector<std::uint8_t> parted;  // of each basin: a saddle keeps it from another one
};

Flooded flood(const Grid<float>& height, const TouchingOptions& options) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < height.values.size(); ++k)
    if (height.values[k] != kEmpty) order.push_back(k);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return height.values[a] > height.values[b]; });
  std::vector<std::uint32_t> basin(height.values.size(), kNone);
  Basins basins;
  std::vector<std::uint8_t> parted;
  for (const std::size_t k : order) {
    const float at = height.values[k];
    std::uint32_t mine = kNone;
    for_neighbours(height.geometry, k, [&](std::size_t n) {
      if (basin[n] == kNone) return;
      const std::uint32_t other = basins.root(basin[n]);
      if (mine == kNone) mine = other;
      if (mine == other) return;
      const auto [high, low] = basins.top[mine] >= basins.top[other] ? std::pair(mine, other) : std::pair(other, mine);
      const double depth = static_cast<double>(basins.top[low] - at);
      const bool apart = depth >= options.saddle_m &&
                         depth >= options.saddle_share * static_cast<double>(basins.top[low]) &&
                         basins.cells[low] >= kLeastCells && basins.cells[high] >= kLeastCells;
      if (apart) {
        parted[low] = parted[high] = 1;
        return;
      }
      basins.parent[low] = high;
      basins.cells[high] += basins.cells[low];
      if (parted[low] != 0) parted[high] = 1;
      mine = high;
    });
    if (mine == kNone) {
      mine = static_cast<std::uint32_t>(basins.parent.size());
      basins.parent.push_back(mine), basins.top.push_back(at), basins.cells.push_back(0), parted.push_back(0);
    }
    basin[k] = mine;
    ++basins.cells[mine];
  }
  for (auto& b : basin)
    if (b != kNone) b = basins.root(b);
  return {std::move(basin), std::move(parted)};
}

}  // namespace

void TouchingOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("saddle-share", saddle_share, 0.0, 1.0, "depth of the saddle between touching rocks over the lower top");
  visitor.real("saddle-m", saddle_m, 0.0, 100.0, "depth of the saddle between touching rocks, m");
  visitor.real("saddle-cell-spacings", cell_spacings, 1.0, 100.0, "cell of the heights over the spacing of the points");
}

std::vector<Candidate> part_touching(const Candidate& candidate, std::span<const Vec3> points,
                                     const GroundFilterResult& ground, const TouchingOptions& options) {
  TouchingOptions checked = options;
  base::validate(base::bind_options(checked), "touching rocks");
  std::vector<Vec3> own;
  own.reserve(candidate.points.size());
  for (const auto i : candidate.points) own.push_back(points[i]);
  const double wide = 2.0 * candidate.radius;
  const double cell = std::max(
      {options.cell_spacings * point_spacing(own), wide / std::sqrt(static_cast<double>(kMostCells)), 1e-6 * wide});
  if (!(cell > 0.0)) return {candidate};
  const auto height = top_heights(candidate, points, ground, cell);
  const auto [basin, parted] = flood(height, options);

  // Basins between saddles in the order of their first cell; what is cut off by a gap goes to the nearest of them.
  std::vector<std::size_t> first;
  std::vector<std::uint32_t> number(height.values.size(), kNone);
  for (std::size_t k = 0; k < basin.size(); ++k)
    if (basin[k] != kNone && parted[basin[k]] != 0 && number[basin[k]] == kNone) {
      number[basin[k]] = static_cast<std::uint32_t>(first.size());
      first.push_back(k);
    }
  if (first.size() < 2) return {candidate};
  const GridGeometry& g = height.geometry;
  std::vector<Candidate> parts(first.size());
  std::vector<std::uint32_t> part_of(basin.size(), kNone);
  for (std::size_t k = 0; k < basin.size(); ++k) {
    if (basin[k] == kNone) continue;
    part_of[k] = number[basin[k]];
    if (part_of[k] != kNone) continue;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < basin.size(); ++n) {
      if (basin[n] == kNone || number[basin[n]] == kNone) continue;
      const double d = (g.centre(n / g.columns, n % g.columns) - g.centre(k / g.columns, k % g.columns)).squaredNorm();
      if (d < best) best = d, part_of[k] = number[basin[n]];
    }
  }
  for (std::size_t k = 0; k < part_of.size(); ++k)
    if (part_of[k] != kNone) {
      Candidate& part = parts[part_of[k]];
      if (part.area == 0.0) part.anchor = g.centre(k / g.columns, k % g.columns);
      part.area += g.cell * g.cell;
    }
  for (const auto i : candidate.points) {
    Candidate& part = parts[part_of[clamped_cell(g, points[i].head<2>())]];
    part.points.push_back(i);
    part.height = std::max(part.height, ground.surface.height_above(points[i]));
  }
  for (Candidate& part : parts) {
    std::vector<Vec2> plan;
    plan.reserve(part.points.size());
    for (const auto i : part.points) plan.push_back(points[i].head<2>());
    part.footprint = geometry::convex_hull(std::move(plan));
    const auto circle = geometry::smallest_enclosing_circle(part.footprint);
    part.centre = circle.centre;
    part.radius = circle.radius;
    part.ground_up = ground.surface.up(part.centre);
    part.touches_border = candidate.touches_border;
  }
  return parts;
}

}  // namespace cairn::segmentation
