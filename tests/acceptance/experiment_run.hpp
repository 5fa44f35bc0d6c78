// One seed of a simulated flight: recorded, tracked, located in both modes, fitted, scored.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "io/json.hpp"
#include "simulation/scene.hpp"

namespace cairn::acceptance {

// What the poses are like. scene: as the scene's file has them; rtk: 2 cm and 0.3 deg; gps: a slow bias of 1.5 m and
// 1 deg, drawn for each flight, that wanders by 1 cm per square root of a second.
[[nodiscard]] simulation::Scene with_pose_grade(simulation::Scene scene, const std::string& grade);

struct RunOptions {
  std::string grade = "scene";
  bool tracks = true;  // SORT first, with the public code's options
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
