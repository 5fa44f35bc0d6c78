#include "ground/false_vehicles.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::ground {

int choose_vehicle(std::span<PoseUpdate> candidates, std::span<const geometry::Mat2> covariances,
                   const PoseEstimate& predicted, const geometry::Vec2& inertial_position, double elapsed_s,
                   double speed_m_s, const PoseFilterOptions& options) {
  const bool paper = options.mode == "paper";
  // A log that says the vehicle went faster is believed.
  const double way = std::max(options.max_speed_m_s, speed_m_s) * elapsed_s;
  int best = -1;
  double nearest = 0.0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    auto& c = candidates[i];
    if (!c.reason.empty() && c.reason != "not_nearest") continue;
    c.residual = c.position - predicted.position();
    c.gate = std::sqrt(gate_distance2(predicted, c.position, covariances[i]));
    const geometry::Mat2 spread = predicted.position_covariance() + covariances[i];
    const double sigmas = options.gate_sigma * std::sqrt(std::max(spread(0, 0), spread(1, 1)));
    const double reach = way + (paper ? options.jump_margin_m : std::max(options.jump_margin_m, sigmas));
    if (predicted.accepted_any && (c.position - predicted.accepted_position).norm() > reach)
      c.reason = "impossible_move";
    else if (!paper && c.gate > options.gate_sigma) c.reason = "outside_gate";
    else {
      c.reason = "not_nearest";
      const double distance = paper ? (c.position - inertial_position).norm() : c.gate;
      if (best < 0 || distance < nearest) {
        best = static_cast<int>(i);
        nearest = distance;
      }
    }
  }
  if (best >= 0) {
    candidates[static_cast<std::size_t>(best)].accepted = true;
    candidates[static_cast<std::size_t>(best)].reason.clear();
  }
  return best;
}

}  // namespace cairn::ground
