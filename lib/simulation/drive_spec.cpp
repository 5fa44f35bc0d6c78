#include "simulation/drive_spec.hpp"

#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::simulation {
namespace {

[[noreturn]] void fail(const std::string& where, const std::string& found, const std::string& allowed) {
  throw base::Error(base::ErrorCode::invalid_argument, "the scene cannot be driven")
      .record("drive." + where)
      .found(found)
      .allowed(allowed);
}

void range(const std::string& where, double value, double lo, double hi) {
  if (!(value >= lo && value <= hi)) fail(where, base::to_text(value), base::to_text(lo) + " to " + base::to_text(hi));
}

void area(const std::string& where, const geometry::Ring& ring) {
  for (const auto& p : ring)
    if (!p.allFinite()) fail(where, "a point that is not finite", "finite numbers");
  if (ring.size() < 3 || std::abs(geometry::signed_area(ring)) < 1e-6)
    fail(where, std::to_string(ring.size()) + " points", "a polygon of at least 3 points and some area");
}

void check_scanner(const ScannerSpec& s) {
  range("scanner.height_m", s.height_m, 0.01, 10.0);
  range("scanner.rate_hz", s.rate_hz, 0.1, 50.0);
  range("scanner.turn_s", s.turn_s, 0.0, 1.0 / s.rate_hz);
  range("scanner.field_deg", s.field_deg, 1.0, 360.0);
  range("scanner.step_deg", s.step_deg, 0.01, s.field_deg);
  range("scanner.range_min_m", s.range_min_m, 0.001, 100.0);
  range("scanner.range_max_m", s.range_max_m, s.range_min_m, 1000.0);
  range("scanner.sigma_m", s.sigma_m, 0.0, 10.0);
  range("scanner.dropout_share", s.dropout_share, 0.0, 1.0);
}

}  // namespace

void validate(const DriveSpec& drive) {
  if (drive.area.empty()) fail("area", "nothing", "a polygon");
  area("area", drive.area);
  for (const auto& [name, place] : {std::pair("start", drive.start), std::pair("goal", drive.goal)})
    if (!place.allFinite() || !geometry::contains(drive.area, place))
      fail(name, base::to_text(place.x()) + "," + base::to_text(place.y()), "a place inside drive.area");
  for (std::size_t i = 0; i < drive.prior_blocked.size(); ++i)
    area("prior_blocked[" + std::to_string(i) + "]", drive.prior_blocked[i]);
  range("heading_deg", drive.heading_deg, -360.0, 360.0);
  range("start_s", drive.start_s, 0.0, 3600.0);
  range("limit_s", drive.limit_s, drive.start_s + 1.0, 7200.0);
  range("goal_tolerance_m", drive.goal_tolerance_m, 0.05, 10.0);
  if (drive.link != "football" && drive.link != "park") fail("link", drive.link, "football or park");
  if (drive.body.object_class.empty()) fail("body.class", "nothing", "a name");
  range("body.length_m", drive.body.length_m, 0.05, 20.0);
  range("body.width_m", drive.body.width_m, 0.05, 20.0);
  range("body.height_m", drive.body.height_m, 0.05, 20.0);
  check_scanner(drive.scanner);
  range("inertial.rate_hz", drive.inertial.rate_hz, 10.0, 1000.0);
  range("inertial.velocity_noise_m_s", drive.inertial.velocity_noise_m_s, 0.0, 10.0);
  range("inertial.velocity_bias_m_s", drive.inertial.velocity_bias_m_s, 0.0, 10.0);
  range("inertial.heading_deg", drive.inertial.heading_deg, 0.0, 180.0);
}

}  // namespace cairn::simulation
