#include "segmentation/ground_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "segmentation/bare_earth.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;
using geometry::GridGeometry;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kMostCells = 4e8;
constexpr double kLeastCell = 0.005;   // m
constexpr std::size_t kPiece = 65536;  // points of one piece of parallel work
constexpr std::size_t kBlock = 512;    // points whose cells are found before they are touched
constexpr std::size_t kAhead = 12;     // cells fetched ahead: a grid is larger than the cache
constexpr double kHighest = 1e30;      // m; what lies beyond is no height

struct Extent {
  Vec2 lo = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 hi = Vec2::Constant(-std::numeric_limits<double>::infinity());
  std::size_t points = 0;
};

// Finite, and of a size that floats hold.
bool usable(const Vec3& p) {
  return std::abs(p.x()) + std::abs(p.y()) + std::abs(p.z()) < kHighest;
}

Extent extent_of(std::span<const Vec3> points) {
  std::vector<Extent> pieces((points.size() + kPiece - 1) / kPiece);
  base::parallel_for(points.size(), kPiece, [&](std::size_t begin, std::size_t end) {
    Extent& e = pieces[begin / kPiece];
    for (std::size_t i = begin; i < end; ++i) {
      if (!usable(points[i])) continue;
      e.lo = e.lo.cwiseMin(points[i].head<2>());
      e.hi = e.hi.cwiseMax(points[i].head<2>());
      ++e.points;
    }
  });
  Extent all;
  for (const Extent& e : pieces) {
    all.lo = all.lo.cwiseMin(e.lo);
    all.hi = all.hi.cwiseMax(e.hi);
    all.points += e.points;
  }
  if (all.points == 0)
    throw base::Error(base::ErrorCode::invalid_input, "the cloud has no finite point")
        .hint("Check the cloud with `cairn info`.");
  return all;
}

Grid<LowCell> low_cells(std::span<const Vec3> points, const GridGeometry& g) {
  Grid<LowCell> grid(g, LowCell{});
  LowCell* cells = grid.values.data();
  std::array<std::uint32_t, kBlock + kAhead> index{};
  constexpr std::uint32_t kNoCell = std::numeric_limits<std::uint32_t>::max();
  const double per_cell = 1.0 / g.cell;
  const auto last_column = static_cast<double>(g.columns - 1), last_row = static_cast<double>(g.rows - 1);
  for (std::size_t begin = 0; begin < points.size(); begin += kBlock) {
    const std::size_t n = std::min(kBlock, points.size() - begin);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3& p = points[begin + i];
      const double c = std::clamp((p.x() - g.west) * per_cell, 0.0, last_column);
      const double r = std::clamp((g.north - p.y()) * per_cell, 0.0, last_row);
      index[i] = usable(p) ? static_cast<std::uint32_t>(r) * static_cast<std::uint32_t>(g.columns) +
                                 static_cast<std::uint32_t>(c)
                           : kNoCell;
    }
    for (std::size_t i = 0; i < std::min(n, kAhead); ++i)
      if (index[i] != kNoCell) __builtin_prefetch(cells + index[i], 1);
    for (std::size_t i = 0; i < n; ++i) {
      if (i + kAhead < n && index[i + kAhead] != kNoCell) __builtin_prefetch(cells + index[i + kAhead], 1);
      if (index[i] == kNoCell) continue;
      LowCell& cell = cells[index[i]];
      const double z = points[begin + i].z();
      cell.low = std::min(cell.low, static_cast<float>(z));
      cell.sum += z;
      ++cell.points;
    }
  }
  return grid;
}

struct Level {
  float height, tolerance;
};

// Bilinear place of p among cell centres: upper left cell and weights.
struct Place {
  std::uint32_t cell;
  float down, right;
};
// at within 0 .. last (NaN: 0), as whole cells before the last and the rest.
std::pair<std::uint32_t, float> axis_place(double at, double last, double most) {
  at = at > 0.0 ? at : 0.0;
  at = at < last ? at : last;
  const double lower = at < most ? at : most;
  const auto whole = static_cast<std::int32_t>(lower);
  return {static_cast<std::uint32_t>(whole), static_cast<float>(at - whole)};
}
struct PlaceFinder {
  explicit PlaceFinder(const GridGeometry& g)
      : west(g.west),
        north(g.north),
        per_cell(1.0 / g.cell),
        last_row(static_cast<double>(g.rows) - 1.0),
        last_column(static_cast<double>(g.columns) - 1.0),
        columns(static_cast<std::uint32_t>(g.columns)) {}
  double west, north, per_cell, last_row, last_column;
  std::uint32_t columns;

  [[nodiscard]] Place operator()(double x, double y) const {
    const auto [row, down] = axis_place((north - y) * per_cell - 0.5, last_row, std::max(last_row - 1.0, 0.0));
    const auto [column, right] = axis_place((x - west) * per_cell - 0.5, last_column, std::max(last_column - 1.0, 0.0));
    return {row * columns + column, down, right};
  }
};

std::vector<PointClass> classify(std::span<const Vec3> points, const GroundSurface& surface) {
  const GridGeometry& g = surface.height.geometry;
  std::vector<Level> levels(g.cells());
  for (std::size_t k = 0; k < levels.size(); ++k) levels[k] = {surface.height.values[k], surface.tolerance.values[k]};
  std::vector<PointClass> classes(points.size());
  const PlaceFinder find(g);
  const std::size_t below = g.rows > 1 ? g.columns : 0, right = g.columns > 1 ? 1 : 0;
  base::parallel_for(points.size(), kPiece, [&](std::size_t begin, std::size_t end) {
    std::array<Place, kBlock + kAhead> places;
    places.fill({0, 0.0F, 0.0F});
    for (std::size_t from = begin; from < end; from += kBlock) {
      const std::size_t n = std::min(kBlock, end - from);
      const Vec3* block = points.data() + from;
      for (std::size_t i = 0; i < n; ++i) places[i] = find(block[i].x(), block[i].y());
      const auto fetch = [&](std::size_t i) {
        const Level* at = levels.data() + places[i].cell;
        __builtin_prefetch(at);
        __builtin_prefetch(at + below);
      };
      for (std::size_t i = 0; i < kAhead; ++i) fetch(i);
      for (std::size_t i = 0; i < n; ++i) {
        fetch(i + kAhead);
        const Place& at = places[i];
        const Level* a = levels.data() + at.cell;
        const Level* b = a + below;
        const auto mix = [&at](float p00, float p01, float p10, float p11) {
          const float top = p00 + at.right * (p01 - p00), bottom = p10 + at.right * (p11 - p10);
          return top + at.down * (bottom - top);
        };
        const float up = mix(a->height, a[right].height, b->height, b[right].height);
        const float tolerance = mix(a->tolerance, a[right].tolerance, b->tolerance, b[right].tolerance);
        const float height = static_cast<float>(block[i].z()) - up;
        // Without branches: ground 1, above 2, below 3, unknown 0.
        const int kind = 1 + (height > tolerance ? 1 : 0) + (height < -tolerance ? 2 : 0);
        classes[from + i] = static_cast<PointClass>(usable(block[i]) ? kind : 0);
      }
    }
  });
  return classes;
}

}  // namespace

void GroundFilterOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("max-object-m", max_object_m, 0.0, 500.0, "widest object that is taken off the ground, m");
  visitor.real("ground-cell-m", cell_m, 0.0, 100.0, "edge of a cell of the ground grid, m; 0: from the next two");
  visitor.real("object-cells", object_cells, 1.0, 1000.0, "cells across the widest object");
  visitor.real("cell-spacings", cell_spacings, 0.25, 20.0, "edge of a cell in mean point spacings, at least");
  visitor.real("object-slope", object_slope, 0.0, 10.0,
               "what an opening cuts off by more than this times its radius is an object");
  visitor.real("tolerance-m", tolerance_m, 0.0, 10.0, "height above level ground that is still ground, m; 0: in cells");
  visitor.real("tolerance-cells", tolerance_cells, 0.0, 10.0, "the same in cells");
  visitor.real("tolerance-slope", tolerance_slope, 0.0, 10.0, "added to the tolerance, times cell times slope");
  visitor.real("roughness-factor", roughness_factor, 0.0, 20.0, "added to the tolerance, times the ground's roughness");
}

double GroundSurface::up(const Vec2& p) const {
  const GridGeometry& g = height.geometry;
  const Place at = PlaceFinder(g)(p.x(), p.y());
  const std::size_t below = g.rows > 1 ? g.columns : 0, right = g.columns > 1 ? 1 : 0;
  const auto z = [&](std::size_t i) { return static_cast<double>(height.values[at.cell + i]); };
  const double top = z(0) + static_cast<double>(at.right) * (z(right) - z(0));
  const double bottom = z(below) + static_cast<double>(at.right) * (z(below + right) - z(below));
  return top + static_cast<double>(at.down) * (bottom - top);
}

GridGeometry ground_grid(const Vec2& low, const Vec2& high, std::uint64_t count, const GroundFilterOptions& options) {
  const Vec2 size = high - low;
  double cell = options.cell_m;
  if (!(cell > 0.0)) {
    // Mean distance of neighbours in plan, were the points spread evenly over their box.
    const double spacing = std::sqrt(size.prod() / static_cast<double>(std::max<std::uint64_t>(count, 1)));
    cell = std::max(options.cell_spacings * spacing, options.max_object_m / options.object_cells);
    // Two digits, so that a few points more or less give the same grid.
    const double unit = std::pow(10.0, std::floor(std::log10(std::max(cell, kLeastCell))) - 1.0);
    cell = std::max(std::round(cell / unit) * unit, kLeastCell);
  }
  const double cells = (size.x() / cell + 1.0) * (size.y() / cell + 1.0);
  if (!(cells <= kMostCells))
    throw base::Error(base::ErrorCode::failed_precondition, "the cloud's extent needs too many cells")
        .found(base::to_text(size.x()) + " x " + base::to_text(size.y()) + " m in cells of " + base::to_text(cell) +
               " m")
        .allowed("400 million cells")
        .hint("Use larger cells, or remove stray points far from the survey.");
  // Cells own their western and northern border: the easternmost and southernmost points need room.
  const double nudge = 1e-6 * cell;
  return geometry::covering_grid(low - Vec2(0.0, nudge), high + Vec2(nudge, 0.0), cell);
}

GroundFilterResult filter_ground(std::span<const Vec3> points, const GroundFilterOptions& options,
                                 base::RunContext& ctx) {
  GroundFilterOptions checked = options;
  base::validate(base::bind_options(checked), "ground");
  const Extent extent = extent_of(points);
  return filter_ground(points, ground_grid(extent.lo, extent.hi, extent.points, options), options, ctx);
}

GroundFilterResult filter_ground(std::span<const Vec3> points, const GridGeometry& geometry,
                                 const GroundFilterOptions& options, base::RunContext& ctx) {
  GroundFilterOptions checked = options;
  base::validate(base::bind_options(checked), "ground");
  ctx.check_memory(40 * static_cast<std::uint64_t>(geometry.cells()) + points.size(), "ground grid");
  GroundFilterResult result;
  result.surface = bare_earth(low_cells(points, geometry), options);
  ctx.check_stop();
  result.classes = classify(points, result.surface);
  const auto count = [&](PointClass c) {
    return static_cast<std::size_t>(std::count(result.classes.begin(), result.classes.end(), c));
  };
  result.not_finite = count(PointClass::unknown);
  result.above = count(PointClass::above);
  result.below = count(PointClass::below);
  result.ground = points.size() - result.not_finite - result.above - result.below;
  return result;
}

}  // namespace cairn::segmentation
