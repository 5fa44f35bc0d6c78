// A 2-D range scanner among the blocked cells of a map.
#pragma once

#include <cstdint>

#include "base/options.hpp"
#include "base/random.hpp"
#include "geometry/grid.hpp"
#include "geometry/pose2.hpp"
#include "survey/range_scan.hpp"

namespace cairn::simulation {

// Defaults: a Hokuyo UTM-30LX (paper B, B2) at a coarser step, cut off where drives need no more.
struct GridScannerOptions {
  double rate_hz = 10.0;
  double field_deg = 270.0;  // of view, about the forward axis
  double step_deg = 1.0;     // between rays
  double range_min_m = 0.1;
  double range_max_m = 10.0;
  double sigma_m = 0.02;         // of a range
  double dropout_share = 0.002;  // of rays without a measurement

  void visit(base::OptionVisitor& v) {
    v.real("scan-rate-hz", rate_hz, 0.1, 100.0, "turns of the simulated scanner a second");
    v.real("scan-field-deg", field_deg, 1.0, 360.0, "its field of view about the forward axis");
    v.real("scan-step-deg", step_deg, 0.05, 45.0, "angle between its rays");
    v.real("scan-range-min-m", range_min_m, 0.0, 100.0, "nearer things give no range");
    v.real("scan-range-max-m", range_max_m, 0.1, 1000.0, "farther things give no range");
    v.real("scan-sigma-m", sigma_m, 0.0, 10.0, "noise of a range");
    v.real("scan-dropout-share", dropout_share, 0.0, 1.0, "rays without a measurement");
  }
};

// One turn at a standstill (all rays at time_ns): the range to where a ray enters a cell with blocked != 0, plus noise;
// +infinity beyond range_max_m, -infinity below range_min_m, NaN for dropouts (REP-117). Outside the grid is free.
// Cost: cells along the rays.
[[nodiscard]] survey::RangeScan scan_grid(const geometry::Grid<std::uint8_t>& blocked, const geometry::Pose2& sensor,
                                          std::int64_t time_ns, const GridScannerOptions& options,
                                          base::Random& random);

}  // namespace cairn::simulation
