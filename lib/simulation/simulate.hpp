// A survey that was never flown, with its truth.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "geometry/triangle_mesh.hpp"
#include "simulation/flight.hpp"
#include "simulation/object_boxes.hpp"
#include "simulation/scene.hpp"
#include "simulation/shape.hpp"
#include "survey/survey.hpp"
#include "survey/truth.hpp"

namespace cairn::simulation {

inline constexpr double kFirstFrame_s = 1.0;  // time of the first frame on the vehicle's clock

struct Recording {
  survey::Survey survey;           // noisy poses and detections; no tie points
  survey::Truth truth;             // `mesh` of objects is empty: whoever writes them names them
  geometry::TriangleMesh terrain;  // local ENU, m, facing up
  std::vector<Shape> shapes;       // world; one a truth object, in their order
  std::vector<std::string> names;  // of the objects, in their order
  std::vector<std::size_t> specs;  // index in the scene's objects of each
  // Of each frame: the object whose estimation circle (A22) it belongs to; invalid on the search.
  std::vector<survey::ObjectId> circled;
};

// A scene flown without errors: all that does not depend on the seed, so that many seeds of a scene are cheap.
// The scene must outlive it.
class Rehearsal {
 public:
  // Throws invalid_argument (see validate), failed_precondition where the scene does not fit together.
  // Cost: linear in frames times objects in view (a cheap test for those out of view), about 20 us a true box.
  // least_duration_s > 0: the flights are flown again, ways between them included, until then, and cut off there.
  Rehearsal(const Scene& scene, base::RunContext& ctx, double least_duration_s = 0.0);
  ~Rehearsal();
  Rehearsal(Rehearsal&&) noexcept;
  Rehearsal& operator=(Rehearsal&&) noexcept;

  // Same scene and seed, same recording, on any number of threads. The seed draws the errors (poses, detections,
  // clutter); the ground, the objects and the flight belong to the scene alone.
  // Frames' ids count from 1; times are of base boot and start at 1 s. `image` names "images/<id>.<format>" where the
  // scene asks for images. No pictures are made here: the renderer takes shapes, terrain and truth.frames.
  // A detection's box is of the raw image; the true box is that of the whole exposed outline, hidden parts included.
  [[nodiscard]] Recording record(std::uint64_t seed) const;

  // What was flown over and with; references live as long as this.
  [[nodiscard]] const Scene& scene() const;
  [[nodiscard]] const geometry::TriangleMesh& terrain() const;
  [[nodiscard]] const Ground& ground() const;
  [[nodiscard]] const std::vector<PlacedObject>& objects() const;
  [[nodiscard]] const std::vector<Exposure>& exposures() const;
  [[nodiscard]] const Obstruction& obstruction() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The ground and the objects of a recording with the scene's materials, for the renderer. Objects carry their ids.
[[nodiscard]] std::vector<RenderBody> render_bodies(const Scene& scene, const Recording& recording);

// One recording.
[[nodiscard]] Recording simulate(const Scene& scene, std::uint64_t seed, base::RunContext& ctx);

}  // namespace cairn::simulation
