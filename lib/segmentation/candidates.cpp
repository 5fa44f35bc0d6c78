#include "segmentation/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/enclosing_circle.hpp"
#include "geometry/primitives.hpp"
#include "segmentation/grid_fill.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Grid;
using geometry::GridGeometry;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kFirmShare = 0.5;  // of the least height of an object
constexpr std::uint32_t kNoGroup = std::numeric_limits<std::uint32_t>::max();

// Number of the connected group (8 neighbours) of each cell of the mask, by first cell row by row. Returns how many.
std::uint32_t number_groups(const Grid<std::uint8_t>& mask, Grid<std::uint32_t>& group) {
  const GridGeometry& g = mask.geometry;
  group = {g, kNoGroup};
  std::uint32_t count = 0;
  std::vector<std::size_t> open;
  for (std::size_t start = 0; start < mask.values.size(); ++start) {
    if (mask.values[start] == 0 || group.values[start] != kNoGroup) continue;
    group.values[start] = count;
    open.push_back(start);
    while (!open.empty()) {
      const std::size_t k = open.back();
      open.pop_back();
      const std::size_t r = k / g.columns, c = k % g.columns;
      for (std::size_t i = r - (r > 0 ? 1U : 0U); i <= std::min(r + 1, g.rows - 1); ++i)
        for (std::size_t j = c - (c > 0 ? 1U : 0U); j <= std::min(c + 1, g.columns - 1); ++j) {
          const std::size_t n = i * g.columns + j;
          if (mask.values[n] == 0 || group.values[n] != kNoGroup) continue;
          group.values[n] = count;
          open.push_back(n);
        }
    }
    ++count;
  }
  return count;
}

}  // namespace

void CandidateOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("candidate-height-m", min_height_m, 0.0, 1000.0, "lowest object that is taken, m");
  visitor.real("candidate-width-m", min_width_m, 0.0, 1000.0, "narrowest object that is taken, m");
  visitor.real("candidate-max-width-m", max_width_m, 0.0, 1000.0, "widest object that is taken, m; 0: any");
  visitor.real("join-gap-m", join_gap_m, 0.0, 100.0, "gaps up to this width do not part an object, m; 0: one cell");
  visitor.integer("candidate-points", min_points, 1, 1'000'000'000, "fewest points of an object");
}

std::vector<Candidate> find_candidates(std::span<const Vec3> points, const GroundFilterResult& ground,
                                       const CandidateOptions& options) {
  CandidateOptions checked = options;
  base::validate(base::bind_options(checked), "candidates");
  const GridGeometry& g = ground.surface.height.geometry;
  // Noise lifts a point here and there out of the ground's tolerance: such cells do not join objects, those at the
  // side of an object belong to it.
  const double firm = kFirmShare * options.min_height_m;
  Grid<std::uint8_t> above(g, 0), touched(g, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (ground.classes[i] != PointClass::above) continue;
    const std::size_t k = clamped_cell(g, points[i].head<2>());
    touched.values[k] = 1;
    if (ground.surface.height_above(points[i]) >= firm) above.values[k] = 1;
  }
  const double gap = options.join_gap_m > 0.0 ? options.join_gap_m : g.cell;
  // Neighbours over a corner or side are connected anyway, so a gap of n cells needs a reach of n / 2.
  const auto reach = static_cast<std::size_t>(std::ceil(0.5 * gap / g.cell - 1e-9));
  const Grid<std::uint8_t> mask = closed_mask(above, reach);
  Grid<std::uint32_t> group;
  const std::uint32_t count = number_groups(mask, group);
  const Grid<std::uint32_t> inner = group;
  for (std::size_t k = 0; k < touched.values.size(); ++k) {
    if (touched.values[k] == 0 || inner.values[k] != kNoGroup) continue;
    const std::size_t r = k / g.columns, c = k % g.columns;
    for (std::size_t i = r - (r > 0 ? 1U : 0U); i <= std::min(r + 1, g.rows - 1); ++i)
      for (std::size_t j = c - (c > 0 ? 1U : 0U); j <= std::min(c + 1, g.columns - 1); ++j)
        group.values[k] = std::min(group.values[k], inner.values[i * g.columns + j]);
  }

  std::vector<Candidate> found(count);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (ground.classes[i] != PointClass::above) continue;
    const std::uint32_t number = group.values[clamped_cell(g, points[i].head<2>())];
    if (number == kNoGroup) continue;
    Candidate& object = found[number];
    object.points.push_back(static_cast<std::uint32_t>(i));
    object.height = std::max(object.height, ground.surface.height_above(points[i]));
  }
  for (std::size_t k = 0; k < mask.values.size(); ++k) {
    if (group.values[k] == kNoGroup) continue;
    const std::size_t r = k / g.columns, c = k % g.columns;
    Candidate& object = found[group.values[k]];
    if (object.area == 0.0 && object.anchor.isZero()) object.anchor = g.centre(r, c);
    object.area += touched.values[k] != 0 ? g.cell * g.cell : 0.0;
    object.touches_border |= r == 0 || c == 0 || r + 1 == g.rows || c + 1 == g.columns;
  }
  std::erase_if(found, [&](const Candidate& c) {
    return c.height < options.min_height_m || std::sqrt(c.area) < options.min_width_m ||
           c.points.size() < static_cast<std::size_t>(options.min_points);
  });
  for (Candidate& object : found) {
    std::vector<Vec2> plan;
    plan.reserve(object.points.size());
    for (const std::uint32_t i : object.points) plan.push_back(points[i].head<2>());
    object.footprint = geometry::convex_hull(std::move(plan));
    const auto circle = geometry::smallest_enclosing_circle(object.footprint);
    object.centre = circle.centre;
    object.radius = circle.radius;
    object.ground_up = ground.surface.up(object.centre);
  }
  if (options.max_width_m > 0.0)
    std::erase_if(found, [&](const Candidate& c) { return 2.0 * c.radius > options.max_width_m; });
  return found;
}

}  // namespace cairn::segmentation
