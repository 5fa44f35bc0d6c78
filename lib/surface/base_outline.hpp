// Where a rock meets the ground, when nobody drew it.
#pragma once

#include <functional>
#include <span>

#include "geometry/vec.hpp"
#include "survey/contact.hpp"

namespace cairn::surface {

// Outline of the lowest band of the rock (three spacings high), inferred: dropped to the ground where that is
// near (a tenth of the rock's height or six spacings), else at the height of the band, as the rock then stands on
// something. One closed pad, in order; empty where the band has no area in plan. Cost n log n.
[[nodiscard]] survey::Contact foot_outline(std::span<const geometry::Vec3> points,
                                           const std::function<double(const geometry::Vec2&)>& ground, double spacing);

}  // namespace cairn::surface
