// vehicle.csv: an inertial log, a filtered track or the truth of a ground vehicle.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "survey/ground_vehicle.hpp"

namespace cairn::io {

// Columns time_ns,x_m,y_m,vx_m_s,vy_m_s,roll_deg,pitch_deg,heading_deg (clockwise from north) and, where the log has
// them, var_xx_m2,var_xy_m2,var_yy_m2 (all three or none of a row's cells filled). Other columns are ignored. Position,
// velocity: local ENU. Throws not_found, or invalid_input with line and column: a missing column, a number that is not
// finite, times that do not ascend, a covariance that is none. A file without rows gives none.
[[nodiscard]] std::vector<survey::VehicleState> read_vehicle_csv(const std::filesystem::path& path);

// All columns, straight to `path`; headings 0 <= h < 360. Angles read back within 1e-12 rad, the rest exactly. Throws
// invalid_argument where a value is not finite, resource_exhausted where a write fails.
void write_vehicle_csv(const std::filesystem::path& path, std::span<const survey::VehicleState> states);

}  // namespace cairn::io
