// Which box belongs to which target, in one frame.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "localisation/points.hpp"

namespace cairn::localisation {

// Of each box, how many of the points project into it. Points behind the camera count only where
// `cheirality` is false (paper A does not test). Cost points x boxes that their outline meets.
[[nodiscard]] std::vector<std::size_t> count_inside(const Points& points, const View& view,
                                                    std::span<const geometry::PixelBox> boxes, bool cheirality);

// Paper A, A11: the one-to-one pairs of the greatest total score; pairs below `least` (N_pts) are refused.
// score is row-major, targets x boxes. Result: box of each target, or geometry::kUnassigned.
[[nodiscard]] std::vector<std::size_t> associate(const std::vector<double>& score, std::size_t targets,
                                                 std::size_t boxes, double least);

}  // namespace cairn::localisation
