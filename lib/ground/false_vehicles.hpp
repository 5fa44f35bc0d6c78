// Which of the vehicles that the aircraft saw is the one (paper B, B11).
#pragma once

#include <span>

#include "geometry/vec.hpp"
#include "ground/pose_filter.hpp"

namespace cairn::ground {

// Judges the candidates of one packet against the estimate predicted to the time they count for. Fills residual, gate,
// accepted and reason of each; at most one is accepted. covariances: one a candidate, m^2. inertial_position: the
// log's, m. elapsed_s: since a position was last taken. speed_m_s: the log's. paper: step 1 drops what lies farther
// from the position last taken than the vehicle can have gone; step 2 takes what is nearest to the log's own position.
// robust: both, with a Mahalanobis gate between them and the nearest to the prediction; candidates that carry a reason
// already are left as they are. Returns the index of the accepted candidate, -1 where there is none.
[[nodiscard]] int choose_vehicle(std::span<PoseUpdate> candidates, std::span<const geometry::Mat2> covariances,
                                 const PoseEstimate& predicted, const geometry::Vec2& inertial_position,
                                 double elapsed_s, double speed_m_s, const PoseFilterOptions& options);

}  // namespace cairn::ground
