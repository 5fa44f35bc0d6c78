// A rock under a suite of records, scales and directions; and under one-cosine pulses.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "fragility/logistic.hpp"
#include "fragility/rocking_response.hpp"

namespace cairn::fragility {

// One motion: a horizontal component, with the vertical one of the same place where there is one.
struct SuiteMotion {
  std::string name;
  std::vector<double> horizontal;  // m/s^2
  std::vector<double> vertical;    // m/s^2 up; empty = none
  double dt = 0.0;                 // s
  double pga = 0.0, pgv = 0.0;     // of the horizontal component at scale 1, m/s^2 and m/s
};

// The profile of a rock by direction of its motion; empty where it has none (see edge_profile).
using ProfileOfAzimuth = std::function<std::optional<RockingProfile>(double azimuth_deg)>;

struct SuiteOptions {
  double azimuth_step_deg = 30.0;  // the horizontal component is turned to 0, step, .. below 360: both polarities
  double azimuth_deg = -1.0;       // one direction (and its opposite) alone; below 0 = all
  std::int64_t eta_draws = 5;      // values of the restitution between the geometry's and eta-share-max
  // Of the energy that an impact loses by geometry, the greatest share that is not lost in truth
  // (uneven contacts); the draws divide 0 .. this evenly.
  double eta_share_max = 0.5;
  RockingOptions rocking;

  void visit(base::OptionVisitor& visitor);
  [[nodiscard]] std::vector<double> azimuths() const;
  [[nodiscard]] std::vector<double> eta_shares() const;
};

struct SuiteOutcome {
  std::size_t record = 0;    // index of the motion
  std::size_t eta_draw = 0;  // index into eta_shares()
  double scale = 1.0;
  double azimuth_deg = 0.0;  // positive ground motion towards
  double pga_g = 0.0, pgv_over_pga_s = 0.0;
  bool rocked = false, toppled = false;
  double topple_toward_deg = 0.0;  // where it toppled
  bool lifted_off = false;         // see RockingResult
};

// Every motion x scale x azimuth x eta, in that order, the last fastest; parallel over motions and azimuths.
// Overturning is not monotone in the scale: every scale is run. Throws invalid_argument for an empty suite or a
// scale that is not above 0; directions without a profile are left out.
[[nodiscard]] std::vector<SuiteOutcome> run_suite(const ProfileOfAzimuth& profile, std::span<const SuiteMotion> motions,
                                                  std::span<const double> scales, const SuiteOptions& options,
                                                  base::RunContext& ctx);

[[nodiscard]] std::vector<ShakeOutcome> to_shake_outcomes(std::span<const SuiteOutcome> outcomes);

// Overturning by one cosine in the (PGA, PGV/PGA) plane.
struct MapOptions {
  std::int64_t pga_steps = 40, ratio_steps = 40;
  double pga_min_g = 0.02, pga_max_g = 2.0;      // logarithmic steps
  double ratio_min_s = 0.01, ratio_max_s = 1.0;  // likewise

  void visit(base::OptionVisitor& visitor);
};
struct OverturningMap {
  std::vector<double> pga_g, ratio_s;  // ascending
  // Share of directions and restitutions that overturn, 0..1: [ratio index * pga count + pga index].
  std::vector<double> share;
};
// Every cell is run (never bisected). Cost: cells x directions x eta x about 0.1 ms.
[[nodiscard]] OverturningMap overturning_map(const ProfileOfAzimuth& profile, const MapOptions& map,
                                             const SuiteOptions& options, base::RunContext& ctx);

}  // namespace cairn::fragility
