// Rows of a vehicle's motion log before what they lack is derived.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/geodetic.hpp"
#include "io/bytes.hpp"
#include "survey/ground_vehicle.hpp"

namespace cairn::io {

inline constexpr double kLatestSecond = 9.2e9;  // what int64 nanoseconds hold

struct VehicleLogRow {
  survey::VehicleState state;
  std::string record;  // for rejects: "line 7"
  bool finite = true, has_velocity = false, has_yaw = false;
};

// The rows of a table with a header. origin: of latitude and longitude; set to the first position where it was unset
// and the table has them, reset where it has metres. convention: one sentence about what was read.
[[nodiscard]] std::vector<VehicleLogRow> csv_vehicle_rows(const FileBytes& file,
                                                          std::optional<geometry::Geodetic>& origin,
                                                          std::string& convention);

}  // namespace cairn::io
