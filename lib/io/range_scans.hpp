// lidar.csv: turns of a 2-D range scanner.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "survey/range_scan.hpp"

namespace cairn::io {

// Columns time_ns (of the first ray), time_increment_ns, angle_min_deg, angle_increment_deg, range_min_m, range_max_m
// and ranges_m: values separated by blanks, with inf, -inf and nan as REP-117 means them. Angles counter-clockwise from
// the sensor's forward axis. Other columns are ignored. Throws not_found, or invalid_input with line and column: a
// missing column, a number that cannot be read, times that do not ascend, an increment of 0, limits that do not ascend.
// A file without rows gives none.
[[nodiscard]] std::vector<survey::RangeScan> read_range_scans(const std::filesystem::path& path);

// Straight to `path`; ranges read back to the same bits, angles within 1e-12 rad. Throws invalid_argument where an
// angle or limit is not finite, resource_exhausted where a write fails.
void write_range_scans(const std::filesystem::path& path, std::span<const survey::RangeScan> scans);

}  // namespace cairn::io
