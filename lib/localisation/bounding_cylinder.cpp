#include "localisation/bounding_cylinder.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::localisation {

geometry::VerticalCylinder bounding_cylinder(const Points& points) {
  const Gaussian g = fit_gaussian(points);
  const double sigma_x = std::sqrt(g.covariance(0, 0)), sigma_y = std::sqrt(g.covariance(1, 1));
  const double sigma_z = std::sqrt(g.covariance(2, 2));
  const double farthest = (points.leftCols<2>().rowwise() - g.mean.head<2>().transpose()).rowwise().norm().maxCoeff();
  geometry::VerticalCylinder cylinder;
  cylinder.axis = g.mean.head<2>();
  cylinder.radius = std::min(farthest, 3.0 * std::max(sigma_x, sigma_y));
  cylinder.bottom = std::max(points.col(2).minCoeff(), g.mean.z() - 3.0 * sigma_z);
  cylinder.top = std::min(points.col(2).maxCoeff(), g.mean.z() + 3.0 * sigma_z);
  // One point, or equal points: rounding of the mean must not turn the cylinder over.
  cylinder.bottom = std::min(cylinder.bottom, cylinder.top);
  return cylinder;
}

}  // namespace cairn::localisation
