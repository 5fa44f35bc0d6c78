// Motion logs of ground vehicles as they come: tables with the usual column names, TUM trajectories, the Plaza logs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/reject.hpp"
#include "geometry/geodetic.hpp"
#include "survey/ground_vehicle.hpp"

namespace cairn::io {

struct VehicleLog {
  std::vector<survey::VehicleState> samples;  // strictly ascending times
  std::string format;                         // csv, tum or plaza
  std::string convention;                     // one sentence: what was read, and how it was converted
  // Where positions were latitude and longitude: what they are local to.
  std::optional<geometry::Geodetic> origin;
  std::vector<base::Reject> rejects;  // time_not_ascending, not_finite
};

// Formats of --format.
[[nodiscard]] const std::vector<std::string>& vehicle_log_formats();

// format: csv, tum, plaza, or auto = by content.
// csv: a header row, separator comma, semicolon or tab; columns in any order and case, others ignored, units in
// brackets taken as part of the name ("Time [s]" is time_s):
//   time    time_ns, timestamp_ns, stamp_ns [ns]; time_us, timestamp_us [us]; time_ms [ms]; time_s, timestamp_s, time,
//           timestamp, t, stamp, sec, seconds [s]
//   east    x_m, x, east_m, east, e, px, position_x, pos_x [m];  north  y_m, y, north_m, north, n, ... [m]
//           or lat, latitude, lat_deg, latitude_deg and lon, lng, longitude, lon_deg, longitude_deg
//   optional vx_m_s, vx, v_east, ...; vy_m_s, ...; roll_deg, roll, pitch_deg, pitch (deg), roll_rad, pitch_rad;
//           heading_deg, heading (clockwise from north, deg); yaw_deg, yaw, yaw_rad, theta (counter-clockwise from
//           east; yaw and theta in rad); var_xx_m2, var_xy_m2, var_yy_m2
// tum: timestamp tx ty tz qx qy qz qw, body x forward. plaza: time [s], way since the row before [m], turn since [rad];
// it starts at the origin towards east.
// Velocities that the log lacks are differences of its positions (over both neighbours), headings that it lacks the
// direction of the velocity (kept while slower than 0.05 m/s). Rows whose time does not ascend or that hold a number
// that is not finite are left out with a reject.
// origin: what latitude and longitude are made local to; unset = the log's first position.
// Throws not_found, or invalid_input with the line for anything else that cannot be read, and where no row is left.
[[nodiscard]] VehicleLog read_vehicle_log(const std::filesystem::path& path, std::string_view format = "auto",
                                          std::optional<geometry::Geodetic> origin = std::nullopt);

}  // namespace cairn::io
