// One turn of a 2-D range scanner on a ground vehicle.
#pragma once

#include <cstdint>
#include <vector>

namespace cairn::survey {

// As sensor_msgs/LaserScan: angles counter-clockwise seen from above, 0 = the sensor's forward axis.
struct RangeScan {
  std::int64_t time_ns = 0;            // of the first ray
  std::int64_t time_increment_ns = 0;  // between rays, >= 0
  double angle_min = 0.0;              // of the first ray, rad
  double angle_increment = 0.0;        // between rays, rad, != 0
  double range_min_m = 0.0;            // shorter ranges are no measurement
  double range_max_m = 0.0;
  // m. REP-117: +infinity = nothing within reach, -infinity = too near to measure, NaN = no measurement.
  std::vector<float> ranges;
};

}  // namespace cairn::survey
