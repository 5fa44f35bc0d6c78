// A flight that was planned: where to fly, where to look, which images to take. Advisory: always a draft.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/vec.hpp"
#include "survey/camera.hpp"
#include "survey/frame.hpp"
#include "survey/manifest.hpp"

namespace cairn::survey {

enum class MissionKind { lawnmower, cylinder, gaps };

[[nodiscard]] std::string_view name_of(MissionKind kind);
[[nodiscard]] std::optional<MissionKind> mission_kind_from(std::string_view name);

// What the vehicle does on its way to a waypoint: a stretch of search lane, a circle about a target, a leg between.
enum class WaypointRole { lane, circle, view, transit };

[[nodiscard]] std::string_view name_of(WaypointRole role);
[[nodiscard]] std::optional<WaypointRole> waypoint_role_from(std::string_view name);

// Camera and vehicle are taken as one point (paper A, A25).
struct Waypoint {
  geometry::Vec3 position = geometry::Vec3::Zero();  // local ENU, m
  // Direction of the camera, clockwise from north. Not wrapped: the difference of two waypoints tells how far and which
  // way to turn.
  double heading_deg = 0.0;
  double pitch_deg = -90.0;  // of the camera against the horizon, -90 looks straight down
  bool stop = false;         // comes to rest here
  bool photo = false;        // takes one image here
  double trigger_m = 0.0;    // > 0: from here to the next waypoint an image each so many metres; 0 = none
  WaypointRole role = WaypointRole::transit;
  std::int64_t group = 0;  // lane, circle or target it belongs to, counted from 0
  double time_s = 0.0;     // arrival, from the first waypoint
};

// Polynomials of degree 9 in time since the segment's start, one row a coordinate: east, north, up [m] and yaw [rad,
// counter-clockwise from east, not wrapped]; coefficient k belongs to t^k.
struct PolynomialSegment {
  double duration_s = 0.0;
  std::array<std::array<double, 10>, 4> coefficients{};
};

struct MissionLimits {
  double max_speed_m_s = 0.0;  // of the position, Euclidean norm
  double max_acceleration_m_s2 = 0.0;
  double max_yaw_rate_deg_s = 0.0;

  friend bool operator==(const MissionLimits&, const MissionLimits&) = default;
};

struct Mission {
  std::string name;
  MissionKind kind = MissionKind::lawnmower;
  Origin origin;  // the local ENU frame of every coordinate
  Camera camera;
  MissionLimits limits;
  std::vector<Waypoint> waypoints;
  std::vector<Frame> views;  // images to be taken, ascending id, in order of time; `image` is empty
  std::vector<PolynomialSegment> trajectory;
  std::vector<std::string> notes;  // sentences for whoever flies it
};

}  // namespace cairn::survey
