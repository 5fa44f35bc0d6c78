// One seed of a simulated flight: recorded, tracked, located in both modes, fitted, scored.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "simulation/scene.hpp"

namespace cairn::acceptance {

struct RunOptions {
  std::string grade = "scene";  // label of the poses: the scene as it is, or its twin with rtk or gps poses
  bool tracks = true;           // SORT first, with the public code's options
  // robust; paper: with tracks of detected boxes; paper_coasted: with the tracker's predictions, as the public code.
  std::vector<std::string> modes{"robust", "paper", "paper_coasted"};
  double paper_depth_m = 23;  // d_m of mode paper: the public code's value for this experiment's terrain
  double min_depth_m = 6.0;   // depth range of mode robust: whatever the flight height and the camera's tilt allow
  double max_depth_m = 45.0;
};

// {"seed", "grade", "detector": {tp, fp, fn}, "modes": {"robust": {...}, ...}}: counts of each stage, and of
// robust the errors of every located target, filter and refined.
[[nodiscard]] io::Json run_seed(const simulation::Scene& scene, std::uint64_t seed, const RunOptions& options,
                                base::RunContext& ctx);

}  // namespace cairn::acceptance
