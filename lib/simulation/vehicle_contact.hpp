// Whether a ground vehicle touches what stands in a scene.
#pragma once

#include <span>
#include <vector>

#include "geometry/primitives.hpp"
#include "simulation/drive_spec.hpp"
#include "simulation/placement.hpp"

namespace cairn::simulation {

// What a vehicle can hit: of each object the convex hull, seen from above, of its surface between the ground below
// it and the vehicle's height. A tree's crown above that is no hindrance, its trunk is. Hollows of a body in plan are
// filled.
class VehicleContact {
 public:
  VehicleContact(std::span<const PlacedObject> objects, const VehicleBody& body);

  struct Nearest {
    double distance_m = 0.0;  // between the body's rectangle and the nearest object, 0 = contact
    std::size_t object = 0;   // index in the objects given
  };
  // Centre of the vehicle [local east, north, m], yaw counter-clockwise from east [rad].
  // distance_m is +infinity where there is no object. Cost linear in objects; those far off cost a comparison.
  [[nodiscard]] Nearest nearest(const geometry::Vec2& centre, double yaw) const;

  // One an object; empty where nothing of it is low enough to be hit. Counter-clockwise, local east, north, m.
  [[nodiscard]] const std::vector<geometry::Ring>& outlines() const { return outlines_; }

 private:
  VehicleBody body_;
  std::vector<geometry::Ring> outlines_;
  std::vector<geometry::Vec2> middle_;
  std::vector<double> radius_;
};

// Distance between two convex counter-clockwise rings, 0 where they overlap or touch.
[[nodiscard]] double convex_distance(const geometry::Ring& a, const geometry::Ring& b);

}  // namespace cairn::simulation
