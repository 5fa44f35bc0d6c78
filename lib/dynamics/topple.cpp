#include "dynamics/topple.hpp"

#include <cmath>

#include "base/angle.hpp"

namespace cairn::dynamics {

void ToppleOptions::visit(base::OptionVisitor& visitor) {
  visitor.real("contact-friction", friction, 0.0, 10.0, "3-D check: Coulomb friction of foot and flanks");
  visitor.real("contact-restitution", restitution, 0.0, 1.0, "3-D check: Newton's restitution of a landing corner");
  visitor.real("contact-margin-m", margin_m, 1e-5, 0.1, "3-D check: rounding of the flanks");
  visitor.real("contact-stiffness-n-m", stiffness_n_m, 0.0, 1e15, "3-D check: of each corner; 0 = rigid");
  visitor.real("contact-damping-ns-m", damping_ns_m, 0.0, 1e15, "3-D check: of each corner, with a stiffness");
  visitor.real("time-step-s", step_s, 1e-6, 0.01, "3-D check: fixed time step");
  visitor.integer("solver-iterations", iterations, 1, 10000, "3-D check: of the contact solver, each step");
  visitor.choice("surround", surround, {"none", "plane"}, "3-D check: what the flanks can strike");
  visitor.real("topple-angle-deg", topple_angle_deg, 1.0, 170.0, "3-D check: rotation that counts as toppled");
  visitor.real("settle-s", settle_s, 0.0, 1000.0, "3-D check: simulated at most this long after the motion");
}

std::string_view name_of(ToppleOutcome outcome) {
  switch (outcome) {
    case ToppleOutcome::rested: return "rested";
    case ToppleOutcome::rocked: return "rocked";
    case ToppleOutcome::slid: return "slid";
    case ToppleOutcome::fell_off: return "fell_off";
    case ToppleOutcome::toppled: return "toppled";
    case ToppleOutcome::undecided: return "undecided";
  }
  return "undecided";
}

StepStudy step_convergence(const RigidRock& rock, const BaseMotion& motion, const ToppleOptions& options, int halvings,
                           const BodyStart& start) {
  constexpr double kRelative = 0.05;  // of the greatest tilt
  const double absolute = base::deg_to_rad(0.1);
  StepStudy study;
  ToppleOptions finer = options;
  finer.sample_s = 0.0;
  for (int i = 0; i <= halvings; ++i) {
    const auto result = topple(rock, motion, finer, start);
    study.rows.push_back({finer.step_s, result.outcome, result.max_tilt_rad, result.time_s});
    finer.step_s *= 0.5;
  }
  if (study.rows.size() < 2) return study;
  const auto& a = study.rows[study.rows.size() - 2];
  const auto& b = study.rows.back();
  const auto fell = [](ToppleOutcome o) { return o == ToppleOutcome::toppled || o == ToppleOutcome::fell_off; };
  study.converged =
      fell(a.outcome) == fell(b.outcome) &&
      (fell(b.outcome) || std::abs(a.max_tilt_rad - b.max_tilt_rad) <= std::max(absolute, kRelative * b.max_tilt_rad));
  return study;
}

}  // namespace cairn::dynamics
