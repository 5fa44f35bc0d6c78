// The camera's way through a scene.
#pragma once

#include <vector>

#include "geometry/rigid_transform.hpp"
#include "simulation/ground.hpp"
#include "simulation/placement.hpp"
#include "simulation/scene.hpp"

namespace cairn::simulation {

struct Exposure {
  double time_s = 0.0;     // since the start of the first flight
  std::size_t camera = 0;  // index in the scene's cameras
  std::size_t flight = 0;  // index in the scene's flights
  // The sought object whose estimation circle (or way there and back) this frame belongs to; invalid on the search.
  survey::ObjectId circled;
  geometry::RigidTransform T_world_camera;
};

// Lanes in the order flown, two points each (local east-north, m). The polygon is cut into strips of equal width, at
// most `spacing` wide, along `azimuth_deg`; a lane runs along the middle of its strip over the whole length of the
// polygon in the strip, so that every point of the polygon is within half a spacing of a lane.
[[nodiscard]] std::vector<std::pair<geometry::Vec2, geometry::Vec2>> lawn_mower_lanes(const geometry::Ring& area,
                                                                                      double azimuth_deg,
                                                                                      double spacing);

// All exposures of all flights, ascending in time. The vehicle moves at constant speed along straight and circular
// parts and turns on the spot between them. Throws failed_precondition where a flight that follows the ground leaves
// it, where an orbit names an object that is not there, or stands on no height above its centre.
[[nodiscard]] std::vector<Exposure> fly(const Scene& scene, const Ground& ground,
                                        const std::vector<PlacedObject>& objects);

}  // namespace cairn::simulation
