#include "simulation/range_scanner.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include "base/angle.hpp"

namespace cairn::simulation {

survey::RangeScan scan(const visibility::Scene& world, const ScannerSpec& scanner, const ScannerMotion& motion,
                       std::int64_t time_ns, base::Random& random) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const auto rays = static_cast<std::size_t>(std::floor(scanner.field_deg / scanner.step_deg + 1e-9)) + 1;
  const double between = rays > 1 ? scanner.turn_s / static_cast<double>(rays - 1) : 0.0;
  survey::RangeScan result;
  result.time_ns = time_ns;
  result.time_increment_ns = static_cast<std::int64_t>(std::llround(1e9 * between));
  result.angle_min = -0.5 * base::deg_to_rad(scanner.field_deg);
  result.angle_increment = base::deg_to_rad(scanner.step_deg);
  result.range_min_m = scanner.range_min_m;
  result.range_max_m = scanner.range_max_m;

  std::vector<geometry::Ray> cast(rays);
  for (std::size_t i = 0; i < rays; ++i) {
    const double t = 1e-9 * static_cast<double>(result.time_increment_ns) * static_cast<double>(i);
    const double angle =
        motion.yaw + motion.yaw_rate * t + result.angle_min + static_cast<double>(i) * result.angle_increment;
    cast[i].origin = motion.position + geometry::Vec3(motion.velocity.x() * t, motion.velocity.y() * t, 0.0);
    cast[i].direction = {std::cos(angle), std::sin(angle), 0.0};
  }
  const auto hits = world.cast(cast, scanner.range_max_m);
  result.ranges.reserve(rays);
  for (const auto& hit : hits) {
    // Every ray draws the same numbers, whatever it meets.
    const double noise = scanner.sigma_m * random.normal();
    const bool lost = random.uniform() < scanner.dropout_share;
    const double range = hit.distance + noise;
    if (lost) result.ranges.push_back(std::numeric_limits<float>::quiet_NaN());
    else if (!hit.hit() || range > scanner.range_max_m) result.ranges.push_back(kInfinity);
    else result.ranges.push_back(range < scanner.range_min_m ? -kInfinity : static_cast<float>(range));
  }
  return result;
}

}  // namespace cairn::simulation
