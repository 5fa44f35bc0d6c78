#include "pipeline/costmap_scans.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "ground/vehicle_track.hpp"
#include "io/range_scans.hpp"
#include "io/vehicle_csv.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using ground::Occupancy;

std::string span_text(std::int64_t begin, std::int64_t end) {
  return std::to_string(begin) + " to " + std::to_string(end) + " ns";
}

}  // namespace

void ScanLayer::rows(std::size_t first, ground::OccupancyGrid& strip) const {
  std::fill(strip.values.begin(), strip.values.end(), Occupancy::unknown);
  const std::size_t begin = std::max(first, region.row);
  const std::size_t end = std::min(first + strip.geometry.rows, region.end_row());
  for (std::size_t r = begin; r < end; ++r)
    std::copy_n(&grid.values[(r - region.row) * region.columns], region.columns, &strip.at(r - first, region.column));
}

ScanLayer gather_scans(const std::filesystem::path& scans_file, const std::filesystem::path& vehicle_file,
                       const geometry::GridGeometry& map, const CostmapStageOptions& options, base::RunContext& ctx) {
  const auto scans = io::read_range_scans(scans_file);
  const auto states = io::read_vehicle_csv(vehicle_file);
  const ground::VehicleTrack track(states, options.max_log_gap_s);
  if (scans.empty()) throw Error(ErrorCode::invalid_input, "a table without scans").file(scans_file.string());
  if (states.empty()) throw Error(ErrorCode::invalid_input, "a log without lines").file(vehicle_file.string());

  ScanLayer layer;
  std::vector<std::size_t> usable;
  Vec2 lo = Vec2::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
  std::size_t without_pose = 0;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    const std::int64_t time = scans[i].time_ns;
    const std::string record = "scan " + std::to_string(i + 1) + " at " + std::to_string(time) + " ns";
    if (const auto pose = track.at(time); !pose) {
      ++without_pose;
      const bool outside = time < track.begin_ns() || time > track.end_ns();
      layer.rejects.push_back({record, outside ? "outside_log" : "log_gap",
                               outside ? "the vehicle's log covers " + span_text(track.begin_ns(), track.end_ns())
                                       : "the vehicle's log has a gap of more than max-log-gap-s there"});
    } else if (track.tilt(time) > base::deg_to_rad(options.max_tilt_deg)) {
      layer.rejects.push_back({record, "tilted", "the vehicle leans by more than max-tilt-deg"});
    } else {
      usable.push_back(i);
      lo = lo.cwiseMin(pose->position);
      hi = hi.cwiseMax(pose->position);
    }
  }
  if (without_pose == scans.size())
    throw Error(ErrorCode::failed_precondition,
                "no scan has a pose: the scans and the vehicle's log do not share times")
        .file(scans_file.string())
        .found(span_text(scans.front().time_ns, scans.back().time_ns))
        .allowed(span_text(track.begin_ns(), track.end_ns()) + " of " + vehicle_file.filename().string())
        .hint("Both tables must be on the survey's time base");

  if (!usable.empty()) {
    // A vehicle may move on during a scan; a second at the speed of a car is more than enough.
    constexpr double kDuringScan_m = 15.0;
    const Vec2 reach = Vec2::Constant(std::max(options.scans.obstacle_range_m, options.scans.clear_range_m) +
                                      std::abs(options.scans.sensor_forward_m) + std::abs(options.scans.sensor_left_m) +
                                      kDuringScan_m);
    layer.region = ground::cells_of(map, lo - reach, hi + reach);
  }
  const geometry::GridGeometry part{map.west + static_cast<double>(layer.region.column) * map.cell,
                                    map.north - static_cast<double>(layer.region.row) * map.cell, map.cell,
                                    layer.region.columns, layer.region.rows};
  ctx.check_memory(6 * part.cells(), "the map of scans");
  ground::ScanMap scan_map(part, options.scans);
  for (const std::size_t i : usable) {
    ctx.check_stop();
    (void)scan_map.add(scans[i], [&](std::int64_t t) { return track.at(t); });
  }
  layer.grid = scan_map.grid();
  const auto& counts = scan_map.counts();
  const auto number = [](std::uint64_t n) { return io::Json(static_cast<std::int64_t>(n)); };
  layer.summary = io::Json::object({{"read", scans.size()},
                                    {"used", number(counts.scans)},
                                    {"rays", number(counts.rays)},
                                    {"rays_marked", number(counts.marked)},
                                    {"rays_cleared_only", number(counts.cleared_only)},
                                    {"rays_too_near", number(counts.too_near)},
                                    {"rays_too_far", number(counts.too_far)},
                                    {"rays_no_measurement", number(counts.no_measurement)},
                                    {"rays_without_pose", number(counts.without_pose)}});
  return layer;
}

}  // namespace cairn::pipeline
