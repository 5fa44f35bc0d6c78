// A survey that was never flown, with its truth.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "geometry/triangle_mesh.hpp"
#include "simulation/scene.hpp"
#include "simulation/shape.hpp"
#include "survey/survey.hpp"
#include "survey/truth.hpp"

namespace cairn::simulation {

struct Recording {
  survey::Survey survey;           // noisy poses and detections; no tie points
  survey::Truth truth;             // `mesh` of objects is empty: whoever writes them names them
  geometry::TriangleMesh terrain;  // local ENU, m, facing up
  std::vector<Shape> shapes;       // world; one a truth object, in their order
  std::vector<std::string> names;  // of the objects, in their order
  // Of each frame: the object whose estimation circle (A22) it belongs to; invalid on the search.
  std::vector<survey::ObjectId> circled;
};

// Same scene and seed, same recording, on any number of threads. The seed draws the errors (poses, detections,
// clutter); the ground, the objects and the flight belong to the scene alone.
// Frames' ids count from 1; times are of base boot and start at 1 s. `image` names "images/<id>.<format>" where the
// scene asks for images. No pictures are made here: the renderer takes shapes, terrain and truth.frames.
// A detection's box is of the raw image; the true box is that of the whole exposed outline, hidden parts included.
// Throws invalid_argument (see validate), failed_precondition where the scene does not fit together.
// Cost: linear in frames times objects, with a cheap test for objects out of view; about 20 us a true box.
[[nodiscard]] Recording simulate(const Scene& scene, std::uint64_t seed, base::RunContext& ctx);

}  // namespace cairn::simulation
