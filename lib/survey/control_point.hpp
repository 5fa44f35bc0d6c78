// A surveyed point and where it is seen: what ties a bundle adjustment to the ground.
#pragma once

#include <string>
#include <vector>

#include "geometry/vec.hpp"
#include "survey/tie_point.hpp"

namespace cairn::survey {

struct ControlPoint {
  std::string name;
  geometry::Vec3 p_world = geometry::Vec3::Zero();  // surveyed position, local ENU, m
  double sigma_xy_m = 0.02, sigma_z_m = 0.03;       // 1 sigma of the surveyed position, > 0
  bool check_only = false;                          // measures the result and takes no part in it
  std::vector<TieObservation> observations;
};

}  // namespace cairn::survey
