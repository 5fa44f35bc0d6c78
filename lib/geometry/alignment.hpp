// The similarity that best brings one set of points onto another.
#pragma once

#include <optional>
#include <span>

#include "geometry/rigid_transform.hpp"

namespace cairn::geometry {

// Least squares: minimises sum w_i |to_i - T from_i|^2 (Umeyama 1991, eq. 39 to 42), with_scale = false keeps scale 1.
// weights: one a point, >= 0; empty = all 1. Empty result where fewer than 3 points weigh anything, or where they lie
// in one point or on one line (second singular value of `from` below 1e-3 of the first): then the rotation is open.
// Cost linear in points.
[[nodiscard]] std::optional<Similarity> align_points(std::span<const Vec3> from, std::span<const Vec3> to,
                                                     bool with_scale = true, std::span<const double> weights = {});

// T applied to a pose: its position as any point, its axes turned; the scale stays in the positions.
[[nodiscard]] RigidTransform transform_pose(const Similarity& T_to_from, const RigidTransform& pose);

}  // namespace cairn::geometry
