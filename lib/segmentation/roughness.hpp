// Whether points lie on a skin, as those of rock and soil do, or fill a volume, as those of shrubs and grass do.
#pragma once

#include <span>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::segmentation {

// Root mean square distance of the points within `reach` [m] of each place from a quadratic surface fitted to them, in
// the direction of their least scatter, m; NaN where fewer than 12 are near. Curvature does not count, noise does: it
// is to be compared with that of known ground. Places and points finite. Cost: places x their neighbours.
[[nodiscard]] std::vector<float> skin_residuals(std::span<const geometry::Vec3> places,
                                                std::span<const geometry::Vec3> points, double reach);

// Lower quantile (0..1) of the residuals that are known; 0 where none is.
[[nodiscard]] double residual_quantile(std::vector<float> residuals, double quantile);

}  // namespace cairn::segmentation
