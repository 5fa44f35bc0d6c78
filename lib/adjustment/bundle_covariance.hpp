// How sure the adjusted poses are.
#pragma once

#include <string>
#include <vector>

#include "adjustment/bundle_system.hpp"

namespace cairn::adjustment {

enum class PoseConstraint {
  none,       // priors or control points fix the seven degrees of freedom
  positions,  // the least-squares alignment of the positions does (inner constraints)
  poses,      // the same with the rotations: positions in one line leave the turn about it open
};

// Covariance of each pose's increment (rotation in camera axes [rad], position in world axes [m]) at the solution:
// the inverse of the reduced normal matrix (points eliminated, the losses' weights applied), to which without a datum
// the constraints are added and their share taken off again (S-transformation, Baarda 1973; Koch 1999, section 3.4).
// full: all correlations, dense. Otherwise the inverse of the pose's own diagonal block: what it would be if all other
// frames were known, which is too small.
// A direction that nothing holds comes out with at most 1 km and 180 deg.
// Memory of full: 8 (6 frames + intrinsics)^2 bytes; time: 2/3 of its cube in multiplications.
[[nodiscard]] std::vector<Mat6> pose_covariances(const BundleSystem& system, PoseConstraint constraint, bool full);

}  // namespace cairn::adjustment
