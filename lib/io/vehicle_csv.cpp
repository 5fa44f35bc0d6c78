#include "io/vehicle_csv.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "base/angle.hpp"
#include "io/csv.hpp"

namespace cairn::io {
namespace {

constexpr std::array<std::string_view, 11> kColumns{"time_ns",   "x_m",       "y_m",       "vx_m_s",
                                                    "vy_m_s",    "roll_deg",  "pitch_deg", "heading_deg",
                                                    "var_xx_m2", "var_xy_m2", "var_yy_m2"};
constexpr double kCorrelationSlack = 1e-9;  // of a covariance's determinant: its producer's rounding

double heading_deg(double yaw) {
  double heading = std::fmod(90.0 - base::rad_to_deg(yaw), 360.0);
  if (heading < 0.0) heading += 360.0;
  return heading < 360.0 ? heading : 0.0;
}

std::optional<geometry::Mat2> covariance_of(const CsvReader& csv, const std::array<std::optional<std::size_t>, 3>& at) {
  std::array<std::optional<double>, 3> v;
  for (std::size_t i = 0; i < v.size(); ++i)
    if (at[i]) v[i] = csv.optional_real(*at[i]);
  if (!v[0] && !v[1] && !v[2]) return std::nullopt;
  if (!v[0] || !v[1] || !v[2])
    throw csv.error("a covariance lacks an element").allowed("all of var_xx_m2, var_xy_m2, var_yy_m2, or none");
  if (*v[0] < 0.0 || *v[2] < 0.0 || *v[1] * *v[1] > *v[0] * *v[2] * (1.0 + kCorrelationSlack))
    throw csv.error("the covariance is not positive semi-definite");
  geometry::Mat2 c;
  c << *v[0], *v[1], *v[1], *v[2];
  return c;
}

}  // namespace

std::vector<survey::VehicleState> read_vehicle_csv(const std::filesystem::path& path) {
  CsvReader csv(path);
  std::array<std::size_t, 8> at{};
  for (std::size_t i = 0; i < at.size(); ++i) at[i] = csv.column(kColumns[i]);
  const std::array variance{csv.find(kColumns[8]), csv.find(kColumns[9]), csv.find(kColumns[10])};
  std::vector<survey::VehicleState> states;
  while (csv.next()) {
    survey::VehicleState s;
    s.time_ns = csv.integer(at[0]);
    if (!states.empty() && s.time_ns <= states.back().time_ns)
      throw csv.error(at[0], "times do not ascend").allowed("more than " + std::to_string(states.back().time_ns));
    s.position = {csv.real(at[1]), csv.real(at[2])};
    s.velocity = {csv.real(at[3]), csv.real(at[4])};
    s.roll = base::deg_to_rad(csv.real(at[5]));
    s.pitch = base::deg_to_rad(csv.real(at[6]));
    s.yaw = std::remainder(base::deg_to_rad(90.0 - csv.real(at[7])), 2.0 * std::numbers::pi);
    s.covariance = covariance_of(csv, variance);
    states.push_back(s);
  }
  return states;
}

void write_vehicle_csv(const std::filesystem::path& path, std::span<const survey::VehicleState> states) {
  CsvWriter csv(path, kColumns);
  for (const auto& s : states) {
    const bool finite = s.position.allFinite() && s.velocity.allFinite() && std::isfinite(s.roll) &&
                        std::isfinite(s.pitch) && std::isfinite(s.yaw) && (!s.covariance || s.covariance->allFinite());
    if (!finite)
      throw base::Error(base::ErrorCode::invalid_argument, "a vehicle state is not finite")
          .file(path.string())
          .record("time " + std::to_string(s.time_ns) + " ns");
    csv.cell(s.time_ns).cell(s.position.x()).cell(s.position.y()).cell(s.velocity.x()).cell(s.velocity.y());
    csv.cell(base::rad_to_deg(s.roll)).cell(base::rad_to_deg(s.pitch)).cell(heading_deg(s.yaw));
    if (s.covariance) {
      const auto& c = *s.covariance;
      csv.cell(c(0, 0)).cell(0.5 * (c(0, 1) + c(1, 0))).cell(c(1, 1));
    } else {
      csv.cell("").cell("").cell("");
    }
    csv.end_row();
  }
  csv.finish();
}

}  // namespace cairn::io
