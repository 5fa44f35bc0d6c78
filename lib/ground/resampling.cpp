#include "ground/resampling.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::ground {
namespace {

using geometry::GridGeometry;
using geometry::Vec2;

constexpr double kThin = 1e-6;  // of a cell: an overlap that does not count

std::size_t clamped(double position, std::size_t count) {
  return static_cast<std::size_t>(std::clamp(position, 0.0, static_cast<double>(count)));
}

// Occupied over unknown over free: what a coarse cell takes from several fine ones.
int weight(Occupancy o) {
  return o == Occupancy::occupied ? 2 : (o == Occupancy::unknown ? 1 : 0);
}

// Turned coordinates: along the grid's own east and north from its lower left corner.
Vec2 turned_back(const Vec2& p, const GridGeometry& from, double yaw) {
  const Vec2 d = p - Vec2(from.west, from.south());
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {c * d.x() + s * d.y(), c * d.y() - s * d.x()};
}

}  // namespace

Resampling::Overlap Resampling::overlap(double begin, double end, std::size_t count) {
  const double first = std::floor(begin + kThin), last = std::ceil(end - kThin);
  return {clamped(first, count), clamped(last, count), first < 0.0 || last > static_cast<double>(count)};
}

Resampling::Resampling(const GridGeometry& from, const GridGeometry& to)
    : from_(from), to_(to), ratio_(to.cell / from.cell), columns_(to.columns) {
  const double west = (to.west - from.west) / from.cell, north = (from.north - to.north) / from.cell;
  for (std::size_t c = 0; c < to.columns; ++c) {
    const double begin = west + static_cast<double>(c) * ratio_;
    columns_[c] = overlap(begin, begin + ratio_, from.columns);
  }
  const auto whole_number = [](double v) { return std::abs(v - std::round(v)) < kThin; };
  aligned_ = std::abs(ratio_ - 1.0) * static_cast<double>(std::max(to.columns, to.rows)) < kThin &&
             whole_number(west) && whole_number(north);
}

Resampling::Overlap Resampling::row(std::size_t row) const {
  const double begin = (from_.north - to_.north) / from_.cell + static_cast<double>(row) * ratio_;
  return overlap(begin, begin + ratio_, from_.rows);
}

std::pair<std::size_t, std::size_t> Resampling::rows_needed(std::size_t first, std::size_t rows) const {
  if (rows == 0) return {0, 0};
  return {row(first).begin, row(first + rows - 1).end};
}

void Resampling::rows(const OccupancyGrid& window, std::size_t window_first, std::size_t first,
                      OccupancyGrid& strip) const {
  for (std::size_t r = 0; r < strip.geometry.rows; ++r) {
    const Overlap over = row(first + r);
    Occupancy* out = &strip.values[r * to_.columns];
    if (over.end == over.begin) {
      std::fill(out, out + to_.columns, Occupancy::unknown);
      continue;
    }
    for (std::size_t c = 0; c < to_.columns; ++c) {
      const Overlap& across = columns_[c];
      Occupancy value = over.outside || across.outside ? Occupancy::unknown : Occupancy::free;
      for (std::size_t i = over.begin; i < over.end; ++i) {
        const Occupancy* in = &window.values[(i - window_first) * from_.columns];
        for (std::size_t j = across.begin; j < across.end; ++j)
          if (weight(in[j]) > weight(value)) value = in[j];
      }
      out[c] = value;
    }
  }
}

OccupancyGrid resampled(const OccupancyGrid& from, const GridGeometry& to) {
  OccupancyGrid result(to, Occupancy::unknown);
  Resampling(from.geometry, to).rows(from, 0, 0, result);
  return result;
}

OccupancyGrid resampled_turned(const OccupancyGrid& from, double yaw, const GridGeometry& to) {
  const GridGeometry& f = from.geometry;
  const double c = std::cos(yaw), s = std::sin(yaw), spread = std::abs(c) + std::abs(s);
  const double half = 0.5 * to.cell / f.cell;  // of a cell of `to`, in cells of `from`
  const double reach = half * spread;          // of its bounding box along the turned axes
  const auto columns = static_cast<double>(f.columns), rows = static_cast<double>(f.rows);
  OccupancyGrid result(to, Occupancy::unknown);
  for (std::size_t r = 0; r < to.rows; ++r)
    for (std::size_t k = 0; k < to.columns; ++k) {
      // Its centre in cells of `from`: to the right, and down from the upper edge.
      const Vec2 local = turned_back(to.centre(r, k), f, yaw);
      const double right = local.x() / f.cell, down = rows - local.y() / f.cell;
      const bool outside = right - reach < -kThin || right + reach > columns + kThin || down - reach < -kThin ||
                           down + reach > rows + kThin;
      Occupancy value = outside ? Occupancy::unknown : Occupancy::free;
      for (std::size_t i = clamped(std::floor(down - reach), f.rows), i1 = clamped(std::ceil(down + reach), f.rows);
           i < i1; ++i)
        for (std::size_t j = clamped(std::floor(right - reach), f.columns),
                         j1 = clamped(std::ceil(right + reach), f.columns);
             j < j1; ++j) {
          if (weight(from.at(i, j)) <= weight(value)) continue;
          // Two squares overlap unless an axis of either one parts them.
          const Vec2 d(static_cast<double>(j) + 0.5 - right, down - (static_cast<double>(i) + 0.5));
          const double along = std::max(std::abs(d.x()), std::abs(d.y()));
          const double across = std::max(std::abs(c * d.x() - s * d.y()), std::abs(s * d.x() + c * d.y()));
          if (along < 0.5 + reach - kThin && across < half + 0.5 * spread - kThin) value = from.at(i, j);
        }
      result.at(r, k) = value;
    }
  return result;
}

GridGeometry grid_around_turned(const GridGeometry& from, double yaw, double cell) {
  const Vec2 corner(from.west, from.south());
  const double width = from.east() - from.west, height = from.north - from.south();
  const Vec2 x(width * std::cos(yaw), width * std::sin(yaw)), y(-height * std::sin(yaw), height * std::cos(yaw));
  Vec2 lo = corner, hi = corner;
  for (const Vec2& p : {Vec2(corner + x), Vec2(corner + y), Vec2(corner + x + y)}) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  return geometry::covering_grid(lo, hi, cell);
}

}  // namespace cairn::ground
