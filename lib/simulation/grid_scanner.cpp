#include "simulation/grid_scanner.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cairn::simulation {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// Way to the first blocked cell along a direction [m]; infinite where there is none within reach.
double first_hit(const geometry::Grid<std::uint8_t>& blocked, const geometry::Vec2& from, double angle, double reach) {
  const auto& g = blocked.geometry;
  const double x = (from.x() - g.west) / g.cell, y = (g.north - from.y()) / g.cell;
  const double dx = std::cos(angle), dy = -std::sin(angle);
  auto column = static_cast<std::int64_t>(std::floor(x)), row = static_cast<std::int64_t>(std::floor(y));
  const auto first = [](double at, double d) { return d > 0.0 ? std::floor(at) + 1.0 - at : at - std::floor(at); };
  const double per_x = dx == 0.0 ? kNever : 1.0 / std::abs(dx), per_y = dy == 0.0 ? kNever : 1.0 / std::abs(dy);
  double next_x = dx == 0.0 ? kNever : per_x * first(x, dx), next_y = dy == 0.0 ? kNever : per_y * first(y, dy);
  double way = 0.0;
  while (way * g.cell <= reach) {
    if (row >= 0 && column >= 0 && row < static_cast<std::int64_t>(g.rows) &&
        column < static_cast<std::int64_t>(g.columns) &&
        blocked.at(static_cast<std::size_t>(row), static_cast<std::size_t>(column)) != 0)
      return way * g.cell;
    if (next_x < next_y) {
      way = next_x;
      next_x += per_x;
      column += dx > 0.0 ? 1 : -1;
    } else {
      way = next_y;
      next_y += per_y;
      row += dy > 0.0 ? 1 : -1;
    }
  }
  return kNever;
}

}  // namespace

survey::RangeScan scan_grid(const geometry::Grid<std::uint8_t>& blocked, const geometry::Pose2& sensor,
                            std::int64_t time_ns, const GridScannerOptions& options, base::Random& random) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  survey::RangeScan scan;
  scan.time_ns = time_ns;
  scan.angle_min = -0.5 * options.field_deg * kDegree;
  scan.angle_increment = options.step_deg * kDegree;
  scan.range_min_m = options.range_min_m;
  scan.range_max_m = options.range_max_m;
  const auto count = static_cast<std::size_t>(options.field_deg / options.step_deg) + 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = sensor.yaw + scan.angle_min + scan.angle_increment * static_cast<double>(i);
    const double noise = options.sigma_m * random.normal();
    const bool dropped = random.uniform() < options.dropout_share;
    const double range = first_hit(blocked, sensor.position, angle, options.range_max_m) + noise;
    double value = range;
    if (dropped) value = std::numeric_limits<double>::quiet_NaN();
    else if (!(range <= options.range_max_m)) value = kNever;
    else if (range < options.range_min_m) value = -kNever;
    scan.ranges.push_back(static_cast<float>(value));
  }
  return scan;
}

}  // namespace cairn::simulation
