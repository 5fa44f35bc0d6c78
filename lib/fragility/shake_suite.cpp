#include "fragility/shake_suite.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "fragility/ground_motion.hpp"

namespace cairn::fragility {
namespace {

using base::Error;
using base::ErrorCode;

struct Direction {
  double azimuth_deg = 0.0;
  std::vector<RockingProfile> by_eta;
};

std::vector<Direction> directions_of(const ProfileOfAzimuth& profile, const SuiteOptions& options) {
  std::vector<Direction> list;
  const auto shares = options.eta_shares();
  for (const double azimuth : options.azimuths()) {
    const auto found = profile(azimuth);
    if (!found) continue;
    Direction d{azimuth, {}};
    for (const double share : shares) d.by_eta.push_back(with_restitution(*found, share));
    list.push_back(std::move(d));
  }
  return list;
}

std::vector<double> log_steps(double lo, double hi, std::int64_t count) {
  std::vector<double> values;
  for (std::int64_t i = 0; i < count; ++i)
    values.push_back(count == 1 ? lo : lo * std::pow(hi / lo, static_cast<double>(i) / static_cast<double>(count - 1)));
  return values;
}

}  // namespace

void SuiteOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("shake-azimuth-step-deg", azimuth_step_deg, 1.0, 180.0, "Directions that each record is turned to");
  visitor.real("shake-azimuth-deg", azimuth_deg, -1.0, 360.0,
               "One direction and its opposite alone, clockwise from north; -1 = all");
  visitor.integer("eta-draws", eta_draws, 1, 100, "Values of the restitution");
  visitor.real("eta-share-max", eta_share_max, 0.0, 1.0,
               "Greatest share of the energy lost at an impact, by geometry, that is kept in truth");
  rocking.visit(visitor);
}

std::vector<double> SuiteOptions::azimuths() const {
  if (azimuth_deg >= 0.0) return {std::fmod(azimuth_deg, 360.0), std::fmod(azimuth_deg + 180.0, 360.0)};
  std::vector<double> list;
  for (int k = 0; k * azimuth_step_deg < 360.0 - 1e-9; ++k) list.push_back(k * azimuth_step_deg);
  return list;
}

std::vector<double> SuiteOptions::eta_shares() const {
  std::vector<double> list;
  for (std::int64_t k = 0; k < eta_draws; ++k)
    list.push_back(eta_share_max * (static_cast<double>(k) + 0.5) / static_cast<double>(eta_draws));
  return list;
}

std::vector<SuiteOutcome> run_suite(const ProfileOfAzimuth& profile, std::span<const SuiteMotion> motions,
                                    std::span<const double> scales, const SuiteOptions& options,
                                    base::RunContext& ctx) {
  if (motions.empty() || scales.empty() ||
      !std::all_of(scales.begin(), scales.end(), [](double s) { return s > 0.0 && std::isfinite(s); }))
    throw Error(ErrorCode::invalid_argument, "a suite needs records, and scales above 0");
  for (const auto& motion : motions)
    if (!(motion.pga > 0.0) || !(motion.pgv > 0.0))
      throw Error(ErrorCode::invalid_argument, "a record of the suite does not move").record(motion.name);
  const auto directions = directions_of(profile, options);
  const std::size_t etas = options.eta_shares().size();
  const std::size_t a_count = directions.size(), s_count = scales.size();
  std::vector<SuiteOutcome> outcomes(motions.size() * s_count * a_count * etas);
  // A piece is one motion in one direction.
  base::parallel_for(motions.size() * a_count, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t piece = begin; piece < end; ++piece) {
      ctx.check_stop();
      const std::size_t m = piece / a_count, a = piece % a_count;
      const auto& motion = motions[m];
      for (std::size_t s = 0; s < s_count; ++s)
        for (std::size_t e = 0; e < etas; ++e) {
          const auto result =
              rock(directions[a].by_eta[e], {motion.horizontal, motion.vertical, motion.dt, scales[s], 0.0, 0.0},
                   options.rocking);
          const double azimuth = directions[a].azimuth_deg;
          outcomes[((m * s_count + s) * a_count + a) * etas + e] = {
              m,
              e,
              scales[s],
              azimuth,
              scales[s] * motion.pga / kGravity,
              motion.pgv / motion.pga,
              result.rocked,
              result.overturned,
              std::fmod(azimuth + (result.side > 0 ? 0.0 : 180.0), 360.0),
              result.lifted_off};
        }
    }
  });
  return outcomes;
}

std::vector<ShakeOutcome> to_shake_outcomes(std::span<const SuiteOutcome> outcomes) {
  std::vector<ShakeOutcome> list;
  list.reserve(outcomes.size());
  for (const auto& o : outcomes) list.push_back({o.pga_g, o.pgv_over_pga_s, o.toppled, o.record});
  return list;
}

void MapOptions::visit(base::OptionVisitor& visitor) {
  visitor.integer("map-pga-steps", pga_steps, 0, 400, "Steps of PGA of the overturning map; 0 = no map");
  visitor.integer("map-ratio-steps", ratio_steps, 0, 400, "Steps of PGV/PGA of the overturning map; 0 = no map");
  visitor.real("map-pga-min-g", pga_min_g, 1e-3, 10.0, "Least PGA of the map");
  visitor.real("map-pga-max-g", pga_max_g, 1e-3, 10.0, "Greatest PGA of the map");
  visitor.real("map-ratio-min-s", ratio_min_s, 1e-3, 10.0, "Least PGV/PGA of the map");
  visitor.real("map-ratio-max-s", ratio_max_s, 1e-3, 10.0, "Greatest PGV/PGA of the map");
}

OverturningMap overturning_map(const ProfileOfAzimuth& profile, const MapOptions& map, const SuiteOptions& options,
                               base::RunContext& ctx) {
  if (!(map.pga_min_g < map.pga_max_g) || !(map.ratio_min_s < map.ratio_max_s))
    throw Error(ErrorCode::invalid_argument, "the overturning map needs ascending ranges");
  OverturningMap out{log_steps(map.pga_min_g, map.pga_max_g, map.pga_steps),
                     log_steps(map.ratio_min_s, map.ratio_max_s, map.ratio_steps),
                     {}};
  const auto directions = directions_of(profile, options);
  out.share.assign(out.pga_g.size() * out.ratio_s.size(), 0.0);
  if (directions.empty()) return out;
  base::parallel_for(out.ratio_s.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r) {
      ctx.check_stop();
      const auto pulse = one_cosine(1.0, out.ratio_s[r]);
      for (std::size_t k = 0; k < out.pga_g.size(); ++k) {
        std::size_t toppled = 0, runs = 0;
        for (const auto& d : directions)
          for (const auto& p : d.by_eta) {
            const double scale = kGravity * out.pga_g[k];
            toppled +=
                rock(p, {pulse.acceleration, {}, pulse.dt, scale, 0.0, 0.0}, options.rocking).overturned ? 1U : 0U;
            ++runs;
          }
        out.share[r * out.pga_g.size() + k] = static_cast<double>(toppled) / static_cast<double>(runs);
      }
    }
  });
  return out;
}

}  // namespace cairn::fragility
