// Three-dimensional toppling beside the plane model: the cross-check of `cairn fragility`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "dynamics/topple.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/rock_results.hpp"
#include "survey/accelerogram.hpp"

namespace cairn::pipeline {

struct DynamicsOptions {
  dynamics::RigidRockOptions body;
  dynamics::ToppleOptions contact;
  // One-cosine pulses towards and against the critical azimuth: PGV/PGA [s], and PGA as multiples of the quasi-static
  // tipping acceleration of that azimuth.
  std::string pulse_ratios_s = "0.05,0.1,0.2,0.4";
  std::string pulse_levels = "1.1,1.5,2,3,5";
  std::int64_t step_halvings = 2;  // of the study in the time step; 0 = none

  void visit(base::OptionVisitor& visitor);
};

// A motion to try on one rock.
struct NamedMotion {
  std::string name;
  double pga_g = 0.0, pgv_over_pga_s = 0.0;  // along `axis_deg`
  double axis_deg = 0.0;                     // azimuth of the plane model, clockwise from north
  dynamics::BaseMotion motion;
};

// The pulses of the options for one rock: for each ratio and level, the ground first accelerating away from the
// critical azimuth. Precondition: rock.tipping.critical.
[[nodiscard]] std::vector<NamedMotion> check_pulses(const survey::Rock& rock, const DynamicsOptions& options);

// Every horizontal component along the critical azimuth, its positive direction away from it, at every scale; vertical
// components are left out. Precondition as above.
[[nodiscard]] std::vector<NamedMotion> check_record_motions(const survey::Rock& rock,
                                                            std::span<const survey::Accelerogram> records,
                                                            std::span<const double> scales);

// Every motion on the rigid body (dynamics::topple) and on the plane model along its axis (fragility::rock on the edges
// of the contact, Housner's impacts, no slip). JSON: the declared parameters, body, runs, counts of equal answers, and
// the study in the time step of the strongest run that stood and of the weakest that toppled. Throws
// failed_precondition for a rock that is not measurable.
[[nodiscard]] io::Json check_3d(const RockResult& result, std::span<const NamedMotion> motions,
                                const DynamicsOptions& options, base::RunContext& ctx);

// All measurable rocks of the results, under the records or, where there are none, the pulses: writes
// <stem>_dynamics.json and <stem>_dynamics.svg into `out`. Summary "dynamics": per rock runs, toppled in three
// dimensions and in the plane, equal answers, whether the step converged.
Outcome dynamics_files(const std::vector<RockResult>& results, std::span<const survey::Accelerogram> records,
                       std::span<const double> scales, const std::filesystem::path& out, const DynamicsOptions& options,
                       base::RunContext& ctx);

}  // namespace cairn::pipeline
