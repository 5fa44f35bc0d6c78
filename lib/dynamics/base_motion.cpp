#include "dynamics/base_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::dynamics {

using base::Error;
using base::ErrorCode;
using geometry::Vec3;

double BaseMotion::duration() const {
  return velocity_m_s.empty() ? 0.0 : step_s * static_cast<double>(velocity_m_s.size() - 1);
}

Vec3 BaseMotion::velocity(double t) const {
  if (t < 0.0 || velocity_m_s.empty()) return Vec3::Zero();
  const double place = t / step_s;
  const auto last = static_cast<double>(velocity_m_s.size() - 1);
  if (place >= last) return velocity_m_s.back();
  const auto i = static_cast<std::size_t>(place);
  const double f = place - static_cast<double>(i);
  return (1.0 - f) * velocity_m_s[i] + f * velocity_m_s[i + 1];
}

BaseMotion one_cosine(double pga_m_s2, double pgv_over_pga_s, double toward_deg, int samples) {
  if (!(pga_m_s2 >= 0.0) || !(pgv_over_pga_s > 0.0) || !std::isfinite(pga_m_s2) || !std::isfinite(pgv_over_pga_s) ||
      samples < 16)
    throw Error(ErrorCode::invalid_argument, "not a pulse")
        .found("PGA " + base::to_text(pga_m_s2) + " m/s2, PGV/PGA " + base::to_text(pgv_over_pga_s) + " s")
        .allowed("PGA >= 0, PGV/PGA > 0");
  const double azimuth = base::deg_to_rad(toward_deg);
  const Vec3 direction(std::sin(azimuth), std::cos(azimuth), 0.0);
  BaseMotion motion;
  motion.step_s = 2.0 * std::numbers::pi * pgv_over_pga_s / samples;
  motion.velocity_m_s.reserve(static_cast<std::size_t>(samples) + 1);
  for (int i = 0; i < samples; ++i)
    motion.velocity_m_s.emplace_back(pga_m_s2 * pgv_over_pga_s * std::sin(2.0 * std::numbers::pi * i / samples) *
                                     direction);
  motion.velocity_m_s.emplace_back(Vec3::Zero());
  return motion;
}

BaseMotion from_acceleration(double step_s, std::span<const Vec3> acceleration_m_s2) {
  BaseMotion motion;
  motion.step_s = step_s;
  motion.velocity_m_s.reserve(acceleration_m_s2.size());
  Vec3 v = Vec3::Zero();
  for (std::size_t i = 0; i < acceleration_m_s2.size(); ++i) {
    if (i > 0) v += 0.5 * step_s * (acceleration_m_s2[i - 1] + acceleration_m_s2[i]);
    motion.velocity_m_s.push_back(v);
  }
  require_valid(motion);
  return motion;
}

BaseMotion scaled(BaseMotion motion, double factor) {
  for (auto& v : motion.velocity_m_s) v *= factor;
  return motion;
}

void require_valid(const BaseMotion& motion) {
  if (!(motion.step_s > 0.0) || !std::isfinite(motion.step_s))
    throw Error(ErrorCode::invalid_argument, "the motion's time step is not positive")
        .found(base::to_text(motion.step_s) + " s");
  const auto bad = std::find_if(motion.velocity_m_s.begin(), motion.velocity_m_s.end(),
                                [](const Vec3& v) { return !v.allFinite(); });
  if (bad != motion.velocity_m_s.end())
    throw Error(ErrorCode::invalid_argument, "the motion has a value that is not finite")
        .record("sample " + std::to_string(bad - motion.velocity_m_s.begin()));
}

}  // namespace cairn::dynamics
