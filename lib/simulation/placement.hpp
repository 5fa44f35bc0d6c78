// Objects of a scene put on its ground.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/ground.hpp"
#include "simulation/scene.hpp"
#include "simulation/shape.hpp"
#include "survey/truth.hpp"

namespace cairn::simulation {

// Triangles of `mesh` above the ground; those that cross it are cut (crossing by bisection along the edges, 1e-4 m).
// Where there is no ground everything is above it.
[[nodiscard]] geometry::TriangleMesh exposed_part(const geometry::TriangleMesh& mesh, const Ground& ground);

struct PlacedObject {
  survey::TruthObject truth;
  Shape shape;                     // world
  geometry::TriangleMesh exposed;  // body above the ground, world
  std::string name;                // of the scene; unique
  std::size_t spec = 0;            // index in the scene's objects
};

// Ids from 1 in the order of the scene. Throws failed_precondition where a scatter finds no room after 10 000 tries
// for one copy, where an object stands off the ground, or where one is wholly below it.
[[nodiscard]] std::vector<PlacedObject> place_objects(const Scene& scene, const Ground& ground);

// Ring's ends and edges.
[[nodiscard]] geometry::Vec2 random_point_in(const geometry::Ring& area, base::Random& random);

}  // namespace cairn::simulation
