#include "planning/view_candidates.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "base/angle.hpp"
#include "planning/camera_aim.hpp"

namespace cairn::planning {
namespace {

using geometry::Vec3;

struct Cell {
  Vec3 middle = Vec3::Zero(), normal = Vec3::Zero();  // weighted sums, then means
  double area = 0.0;
  double gsd = 0.0;  // least asked for; 0 = none
};

int facing_of(const Vec3& normal) {
  constexpr double kUp = 0.7;
  if (normal.z() > kUp) return 8;
  const double turn = std::atan2(normal.x(), normal.y()) / (2.0 * std::numbers::pi) + 1.0;
  return static_cast<int>(std::floor(turn * 8.0)) % 8;
}

std::vector<Cell> cells_of(std::span<const Demand> demands, double edge) {
  std::map<std::array<std::int64_t, 4>, Cell> cells;
  for (const Demand& d : demands) {
    std::array<std::int64_t, 4> key{};
    for (int i = 0; i < 3; ++i)
      key[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(std::floor(d.centre[i] / edge));
    key[3] = facing_of(d.normal);
    Cell& cell = cells[key];
    cell.middle += d.area_m2 * d.centre;
    cell.normal += d.area_m2 * d.normal;
    cell.area += d.area_m2;
    if (d.max_gsd_m > 0.0) cell.gsd = cell.gsd > 0.0 ? std::min(cell.gsd, d.max_gsd_m) : d.max_gsd_m;
  }
  std::vector<Cell> result;
  for (auto& [key, cell] : cells) {
    if (!(cell.area > 0.0) || !(cell.normal.norm() > 0.0)) continue;
    cell.middle /= cell.area;
    cell.normal.normalize();
    result.push_back(cell);
  }
  return result;
}

std::vector<Vec3> directions() {
  std::vector<Vec3> all;
  constexpr int kAzimuths = 24;
  for (const double elevation : {10.0, 22.0, 35.0, 50.0, 65.0, 80.0})
    for (int a = 0; a < kAzimuths; ++a) {
      const double azimuth = 2.0 * std::numbers::pi * a / kAzimuths, e = base::deg_to_rad(elevation);
      all.emplace_back(std::cos(e) * std::sin(azimuth), std::cos(e) * std::cos(azimuth), std::sin(e));
    }
  all.emplace_back(Vec3::UnitZ());
  return all;
}

}  // namespace

CandidateViews candidate_views(std::span<const Demand> demands, const survey::Camera& camera,
                               const SurfaceHeights& surface, const ClearanceOptions& clearance,
                               const CandidateOptions& options) {
  constexpr double kFiner = 0.6;  // of the range that just meets the sampling distance on the axis, head-on
  constexpr double kSecondRange = 0.6;
  constexpr double kGrow = 1.25;
  constexpr double kMargin_deg = 5.0;
  const double steepest = std::cos(base::deg_to_rad(std::max(5.0, options.max_incidence_deg - kMargin_deg)));
  const auto all = directions();
  const double focal = std::sqrt(camera.fx_px * camera.fy_px);
  CandidateViews result;
  for (double edge = options.cell_m;; edge *= kGrow) {
    result = {};
    result.cell_m = edge;
    for (const Cell& cell : cells_of(demands, edge)) {
      double range = options.range_m;
      if (range <= 0.0)
        range = cell.gsd > 0.0 ? std::min(options.most_range_m, kFiner * cell.gsd * focal) : options.most_range_m;
      result.farthest_m = std::max(result.farthest_m, range);
      for (const double at : {range, kSecondRange * range})
        for (const Vec3& d : all) {
          if (d.dot(cell.normal) < steepest) continue;
          Vec3 position = cell.middle + at * d;
          const auto least = least_up(position.head<2>(), surface, clearance);
          if (!least) {
            ++result.unknown;
            continue;
          }
          if (position.z() < *least) {
            position.z() = *least;
            if ((position - cell.middle).normalized().dot(cell.normal) < steepest) {
              ++result.too_low;
              continue;
            }
          }
          const Aim aim = aim_at(position, cell.middle);
          result.candidates.push_back({position, aim.heading_deg, aim.pitch_deg});
        }
      if (result.candidates.size() > options.max_candidates) break;
    }
    // Nine facings of one cell: no coarser way to say it.
    constexpr double kCoarsest_m = 1e5;
    if (result.candidates.size() <= options.max_candidates || edge > kCoarsest_m) return result;
  }
}

}  // namespace cairn::planning
