#include "fragility/rocking_profile.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "fragility/hull_section.hpp"

namespace cairn::fragility {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kHalfPi = 0.5 * std::numbers::pi;

// Corners relative to the centre of mass, ascending along; inertia about the axis through the centre / mass.
RockingProfile profile_of_corners(std::span<const Vec2> corners, double inertia) {
  RockingProfile profile;
  for (const auto& q : corners) {
    Toe toe;
    toe.alpha = std::atan2(q.x(), -q.y());
    toe.p_squared = kGravity * q.norm() / (inertia + q.squaredNorm());
    profile.toes.push_back(toe);
  }
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Vec2 side = corners[i + 1] - corners[i];
    profile.switches.push_back(std::atan2(side.y(), side.x()));
    const double carried = inertia + corners[i].dot(corners[i + 1]);
    profile.toes[i].eta_from_up = carried / (inertia + corners[i].squaredNorm());
    profile.toes[i + 1].eta_from_down = carried / (inertia + corners[i + 1].squaredNorm());
  }
  return profile;
}

// kept(energy ratio of a passage there and back) gives the new ratio; pairs that stop the body stay as they are.
template <typename Kept>
RockingProfile with_energy(RockingProfile profile, Kept kept) {
  for (std::size_t i = 0; i + 1 < profile.toes.size(); ++i) {
    double &down = profile.toes[i].eta_from_up, &up = profile.toes[i + 1].eta_from_down;
    if (!(down > 0.0) || !(up > 0.0)) continue;
    const double factor = std::sqrt(kept(down * up) / (down * up));
    down *= factor;
    up *= factor;
  }
  return profile;
}

}  // namespace

void validate(const RockingProfile& profile) {
  const auto refuse = [](const char* what) { throw Error(ErrorCode::invalid_argument, what); };
  if (profile.toes.size() < 2 || profile.switches.size() + 1 != profile.toes.size() ||
      profile.rest >= profile.switches.size())
    refuse("a rocking profile needs two toes, and one switch less than toes");
  for (std::size_t i = 0; i + 1 < profile.switches.size(); ++i)
    if (!(profile.switches[i] < profile.switches[i + 1])) refuse("the switches of a rocking profile must ascend");
  if (profile.switches[profile.rest] != 0.0) refuse("a rocking profile must rest at 0");
  for (const auto& toe : profile.toes)
    if (!(toe.p_squared > 0.0) || !std::isfinite(toe.p_squared) || !std::isfinite(toe.alpha) ||
        !std::isfinite(toe.gain) || !std::isfinite(toe.eta_from_up) || !std::isfinite(toe.eta_from_down))
      refuse("a toe of a rocking profile needs finite values and p > 0");
  for (std::size_t i = 0; i + 1 < profile.toes.size(); ++i)
    if (profile.toes[i].eta_from_up > 0.0 &&
        profile.toes[i].eta_from_up * profile.toes[i + 1].eta_from_down > 1.0 + 1e-9)
      refuse("an impact of a rocking profile gains energy");
  if (!(profile.toes[profile.rest].alpha < 0.0) || !(profile.toes[profile.rest + 1].alpha > 0.0))
    refuse("the rest of a rocking profile is not stable");
}

TopplingAngles toppling_angles(const RockingProfile& profile) {
  TopplingAngles angles;
  for (const int sign : {-1, 1}) {
    std::size_t i = sign > 0 ? profile.rest + 1 : profile.rest;
    double from = 0.0, height = 1.0;
    double best_height = 0.0, best = profile.toes[i].alpha;
    for (;;) {
      const auto& toe = profile.toes[i];
      // Height of the centre of mass above the plane: r cos(alpha - theta), continuous from toe to toe.
      const double start = std::cos(toe.alpha - from);
      if (!(start > 0.0)) break;
      const double r = height / start;
      const bool last = sign > 0 ? i + 1 == profile.toes.size() : i == 0;
      const double to = last ? sign * kHalfPi : (sign > 0 ? profile.switches[i] : profile.switches[i - 1]);
      // The potential rises to the toe's alpha where that lies ahead, else to the end of its range or not at all.
      const double stop = sign * std::min(sign * to, kHalfPi);
      const bool inside = sign * toe.alpha > sign * from && sign * toe.alpha < sign * stop;
      const double highest = inside ? r : r * std::cos(toe.alpha - stop);
      if (highest > best_height) {
        best_height = highest;
        best = inside ? toe.alpha : stop;
      }
      if (last || sign * to >= kHalfPi) break;
      height = r * std::cos(toe.alpha - to);
      from = to;
      i = sign > 0 ? i + 1 : i - 1;
    }
    (sign > 0 ? angles.up : angles.down) = best;
  }
  return angles;
}

RockingProfile two_toe_profile(double b_up, double h_up, double b_down, double h_down, double inertia_per_mass) {
  for (const double v : {b_up, h_up, b_down, h_down, inertia_per_mass})
    if (!(v > 0.0) || !std::isfinite(v))
      throw Error(ErrorCode::invalid_argument, "toes need positive distances, heights and inertia");
  const std::array<Vec2, 2> corners = {Vec2(-b_down, -h_down), Vec2(b_up, -h_up)};
  auto profile = profile_of_corners(corners, inertia_per_mass);
  profile.switches = {0.0};  // toes of unequal height carry the body together as it stands
  return profile;
}

RockingProfile rectangle_profile(double half_width, double half_height) {
  return two_toe_profile(half_width, half_height, half_width, half_height,
                         (half_width * half_width + half_height * half_height) / 3.0);
}

std::optional<RockingProfile> edge_profile(const TippingResult& result, const geometry::MassProperties& mass,
                                           double azimuth_deg) {
  if (result.equilibrium != Equilibrium::stable) return std::nullopt;
  const double azimuth = base::deg_to_rad(azimuth_deg);
  const Vec3 u(std::sin(azimuth), std::cos(azimuth), 0.0);
  struct Axis {
    const Edge* edge = nullptr;
    Vec3 t = Vec3::Zero(), r = Vec3::Zero(), normal = Vec3::Zero();
    double least = std::numeric_limits<double>::infinity();
  };
  const auto find = [&](const Vec3& push) {
    Axis best;
    for (const auto& edge : result.edges) {
      Vec3 t = (edge.ends[1] - edge.ends[0]).normalized();
      const Vec3 from = mass.centre_of_mass - edge.ends[0];
      const Vec3 r = from - from.dot(t) * t;
      const double n = base::deg_to_rad(edge.azimuth_deg);
      const Vec3 normal(std::sin(n), std::cos(n), 0.0);
      if (t.dot(Vec3::UnitZ().cross(normal)) < 0.0) t = -t;
      // fragility.md 7.2: the push that tips about this edge / g.
      const double a = t.dot(r.cross(Vec3::UnitZ())) / t.dot(r.cross(push));
      if (a > 0.0 && a < best.least) best = {&edge, t, r, normal, a};
    }
    return best;
  };
  const Axis up = find(u), down = find(-u);
  if (!up.edge || !down.edge || !(up.edge->alpha < kHalfPi) || !(down.edge->alpha < kHalfPi)) return std::nullopt;
  RockingProfile profile;
  profile.switches = {0.0};
  const auto toe_of = [&](const Axis& axis, double sign) {
    Toe toe;
    toe.alpha = sign * axis.edge->alpha;
    toe.p_squared = axis.edge->p * axis.edge->p;
    toe.gain = sign * u.dot(axis.normal) / std::cos(axis.edge->inclination);
    return toe;
  };
  profile.toes = {toe_of(down, -1.0), toe_of(up, 1.0)};
  // Positive theta turns about +t of the upper axis and about -t of the lower one.
  const Vec3 t_up = up.t, t_down = -down.t;
  const double carried =
      t_up.dot(mass.inertia_per_density * t_down) / mass.volume + t_up.cross(up.r).dot(t_down.cross(down.r));
  profile.toes[1].eta_from_down = carried / up.edge->inertia_per_mass;
  profile.toes[0].eta_from_up = carried / down.edge->inertia_per_mass;
  return profile;
}

std::optional<RockingProfile> hull_profile(std::span<const Vec3> points, const geometry::MassProperties& mass,
                                           double azimuth_deg) {
  const auto pose = resting_pose(points, mass.centre_of_mass);
  constexpr double kLevel = 1e-6;  // rad
  if (!pose || pose->tilt > kLevel) return std::nullopt;
  const double azimuth = base::deg_to_rad(azimuth_deg);
  const Vec2 along(std::sin(azimuth), std::cos(azimuth));
  const auto corners = lower_section(points, pose->facet, mass.centre_of_mass, along);
  const Vec3 axis(-along.y(), along.x(), 0.0);
  auto profile = profile_of_corners(corners, axis.dot(mass.inertia_per_density * axis) / mass.volume);
  for (std::size_t i = 0; i < profile.switches.size(); ++i)
    if (std::abs(profile.switches[i]) < 2.0 * kLevel && corners[i].x() < 0.0 && corners[i + 1].x() > 0.0) {
      profile.rest = i;
      profile.switches[i] = 0.0;
      return profile;
    }
  return std::nullopt;
}

RockingProfile with_restitution(RockingProfile profile, double share) {
  return with_energy(std::move(profile), [share](double energy) { return energy + share * (1.0 - energy); });
}

RockingProfile with_fixed_restitution(RockingProfile profile, double eta) {
  return with_energy(std::move(profile), [eta](double) { return eta * eta; });
}

}  // namespace cairn::fragility
