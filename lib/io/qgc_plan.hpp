// Missions for QGroundControl: .plan, version 1.
#pragma once

#include <filesystem>
#include <optional>

#include "io/json.hpp"
#include "survey/mission.hpp"

namespace cairn::io {

// Simple items only: DO_CHANGE_SPEED (178), DO_MOUNT_CONTROL (205) where the gimbal's pitch changes, NAV_WAYPOINT (16)
// with its yaw, IMAGE_START_CAPTURE (2000) for single images, DO_SET_CAM_TRIGG_DIST (206) for stretches of them. Never
// a take-off (22, 24, 84) nor a landing or return item: the crew adds those. "groundStation" says DRAFT; what else
// there is to say stands in the member "cairn", which QGroundControl passes over.
//
// Heights: above mean sea level (frame 0) where the origin's are ellipsoidal (EGM96's undulation is taken off) or
// orthometric; above the launch point (frame 3) where they are relative_takeoff, or unknown: then `home_up_m`, local up
// of the launch point, must be given. The planned home is below the first waypoint at home_up_m (local up 0 where that
// is not given). Throws failed_precondition for heights of unknown datum without home_up_m, crs_mismatch where the
// geoid's grid is not installed, invalid_input for a mission without a waypoint or with a number that is not finite.
[[nodiscard]] Json qgc_plan(const survey::Mission& mission, std::optional<double> home_up_m);
void write_qgc_plan(const std::filesystem::path& path, const survey::Mission& mission, std::optional<double> home_up_m);

}  // namespace cairn::io
