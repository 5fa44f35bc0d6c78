// Poses of a metre and a few degrees made to agree with tracks of image points: resection and intersection in turn.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "geometry/rigid_transform.hpp"

namespace cairn::adjustment {

// Where a camera saw a point: on the plane z = 1 of the camera's frame (undistorted).
struct TrackRay {
  std::size_t camera = 0;
  geometry::Vec2 at = geometry::Vec2::Zero();
};

struct RayTrack {
  std::vector<TrackRay> rays;                       // at least two, each camera once
  geometry::Vec3 p_world = geometry::Vec3::Zero();  // m; meaningful where `seen`
  bool seen = false;                                // in front of all its cameras, rays not parallel
};

struct RoughCamera {
  geometry::RigidTransform T_world_camera;                        // start and result
  double sigma_xy_m = 3.0, sigma_z_m = 3.0, sigma_rot_deg = 5.0;  // of the start, > 0
};

struct RoughAlignmentOptions {
  int rounds = 40;           // of resection and intersection
  int plane_rounds = 10;     // the first ones, with all points on the ground plane (where one is given)
  double scale = 0.002;      // residual from which an observation counts less, at least [focal lengths]
  double least_sine = 0.01;  // of the angle between the rays of a point: below, its depth is not known
};

// The point nearest to the rays, each weighted by 1 / depth^2; empty where they are parallel (largest angle between two
// with a sine below least_sine) or the point lies behind a camera.
[[nodiscard]] std::optional<geometry::Vec3> intersect_rays(std::span<const TrackRay> rays,
                                                           std::span<const RoughCamera> cameras, double least_sine);

// Distance, on the plane z = 1, between where the camera sees p_world and the ray; infinite behind the camera.
[[nodiscard]] double ray_residual(const TrackRay& ray, const RoughCamera& camera, const geometry::Vec3& p_world);

// Alternates: points from cameras (first on the plane at `ground_up`, local up [m], which makes the start safe where
// base lines are no longer than the errors of the positions), cameras from points (Gauss-Newton, Huber weights, held by
// their sigmas). Converges to a good start for bundle adjustment, not to its optimum: bends of the whole block remain.
// Returns the median residual [focal lengths]. Cost: rounds times observations, about 1 us each.
double align_roughly(std::vector<RoughCamera>& cameras, std::vector<RayTrack>& tracks, std::optional<double> ground_up,
                     const RoughAlignmentOptions& options = {});

}  // namespace cairn::adjustment
