// Tie and control points on their way into an adjustment: where they are, which of their observations count.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "geometry/rigid_transform.hpp"
#include "survey/camera.hpp"

namespace cairn::adjustment {

struct TrackObservation {
  std::int32_t frame = 0;  // index
  geometry::Vec2 pixel = geometry::Vec2::Zero();
  bool used = false;
  double error_px = 0.0;  // at the last selection; infinite where the point cannot be projected
};

struct Track {
  std::vector<TrackObservation> observations;  // at most one a frame
  geometry::Vec3 p_world = geometry::Vec3::Zero();
  bool placed = false;  // p_world is worth something
  bool used = false;
  std::int32_t control = -1;  // index of the control point, else a tie
  std::string_view reason;    // why it is not used
};

// The cameras as they are at some moment.
struct Views {
  std::span<const survey::Camera> cameras;
  std::span<const geometry::RigidTransform> poses;  // T_world_camera, by frame
  std::span<const std::int32_t> camera_of;          // by frame
};

// Distance observed - projected [px]; infinite where the point cannot be projected.
[[nodiscard]] double reprojection_error(const Views& views, const TrackObservation& seen, const geometry::Vec3& p);

// The point nearest to the rays of all observations (least squares), moved to the least sum of squared pixel
// distances by Gauss-Newton; where one then lies beyond gate_px, the pair of rays that most observations
// agree with (at most 30 pairs). `skip[frame]` leaves a frame out (empty = none). Empty where fewer than two rays
// remain, or they do not meet in front of the cameras.
[[nodiscard]] std::optional<geometry::Vec3> triangulate_track(const Views& views, const Track& track, double gate_px,
                                                              std::span<const char> skip = {});

// Largest angle between two used rays [rad].
[[nodiscard]] double parallax(const Views& views, const Track& track);

struct TrackLimits {
  std::int64_t min_observations = 8;  // of a frame
  double min_parallax_rad = 0.0;
};

// From tracks with `used` set on every acceptable observation: drops points seen by fewer than two frames (a control
// point: one) or without parallax, and frames with too few observations, until nothing changes. `held[frame]` comes in
// with what is held for other reasons and goes out with all of them.
void prune_tracks(const Views& views, const TrackLimits& limits, std::vector<Track>& tracks, std::vector<char>& held);

// Groups of frames joined by at least `shared` common points: a label per frame (the group's first frame), -1 held.
[[nodiscard]] std::vector<std::int32_t> frame_groups(const std::vector<Track>& tracks, const std::vector<char>& held,
                                                     std::size_t shared);

}  // namespace cairn::adjustment
