// A 2-D range scanner on a ground vehicle.
#pragma once

#include <cstdint>

#include "base/random.hpp"
#include "geometry/vec.hpp"
#include "simulation/drive_spec.hpp"
#include "survey/range_scan.hpp"
#include "visibility/scene.hpp"

namespace cairn::simulation {

// Where the scanner is during one turn; it moves evenly.
struct ScannerMotion {
  geometry::Vec3 position = geometry::Vec3::Zero();  // of the sensor at the first ray, local ENU, m
  double yaw = 0.0;                                  // of its forward axis, counter-clockwise from east, rad
  geometry::Vec2 velocity = geometry::Vec2::Zero();  // m/s
  double yaw_rate = 0.0;                             // rad/s
};

// One turn: rays in a level plane from -field/2 to +field/2, each from where the sensor is at its time. A ray that
// meets nothing within range_max_m is +infinity, one that meets something nearer than range_min_m -infinity; dropouts
// are NaN. Ranges carry Gaussian noise of sigma_m. Cost: one ray cast each.
[[nodiscard]] survey::RangeScan scan(const visibility::Scene& world, const ScannerSpec& scanner,
                                     const ScannerMotion& motion, std::int64_t time_ns, base::Random& random);

}  // namespace cairn::simulation
