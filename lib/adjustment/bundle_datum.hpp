// What fixes position, attitude and scale of an adjustment, and the alignment where nothing does.
#pragma once

#include <span>

#include "adjustment/bundle_system.hpp"

namespace cairn::adjustment {

// The frames' sigmas (or the options' in their place) as weights; none with priors off.
[[nodiscard]] BundlePrior prior_of(const survey::Frame& frame, const BundleOptions& options);

// Whether the priors of these frames fix all seven degrees of freedom: three positions not in one line, or two
// positions and a rotation.
[[nodiscard]] bool fixes_datum(std::span<const BundlePrior> priors);

// Whether points lie in one line (second singular value of their spread below 1e-3 of the first), or are fewer than 3.
[[nodiscard]] bool in_line(std::span<const geometry::Vec3> points);

// Brings `from` onto `to`: by the positions, the farthest off left out by their robust spread; where the positions lie
// in line the rotation is the mean of the frames' own. The frame of one pair alone: shift and turn only.
[[nodiscard]] geometry::Similarity align_poses(std::span<const geometry::RigidTransform> from,
                                               std::span<const geometry::RigidTransform> to);

}  // namespace cairn::adjustment
