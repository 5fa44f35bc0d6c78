// The rocking equation of motion under a record, with impacts located in time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "fragility/rocking_profile.hpp"

namespace cairn::fragility {

struct RockingOptions {
  double tolerance = 1e-8;  // error of one step: of theta relative to the toppling angle, of its rate to that times p
  double max_step_s = 0.0;  // longest step; 0 = one step of the record
  double stop_angle_deg = 90;  // beyond this rotation the body has overturned; it may pass alpha and come back

  void visit(base::OptionVisitor& visitor);
};

// Motion of the ground along +u of the profile, and upwards. Straight between samples.
struct RockingInput {
  std::span<const double> horizontal;  // m/s^2, two samples or more
  std::span<const double> vertical;    // m/s^2, positive up; empty = none, else as many as horizontal
  double dt = 0.0;                     // s
  double scale = 1.0;                  // of both components; a negative one turns the horizontal one round
  double theta = 0.0, rate = 0.0;      // initial rotation [rad] and its rate [rad/s]; rest by default
};

struct RockingResult {
  bool overturned = false;
  int side = 0;                     // +1 overturned towards +u, -1 against it
  bool rocked = false;              // left its rest at all
  double first_uplift_s = 0.0;      // where it rocked
  double peak_up = 0.0;             // greatest theta / toppling angle towards +u, during the record and after
  double peak_down = 0.0;           // likewise against u
  std::int64_t impacts = 0;         // changes of toe
  double overturning_time_s = 0.0;  // where the stop angle was reached during the record, else its end
  bool lifted_off = false;  // vertical motion beyond -1 g was held at -1 g: a rigid body would have left the ground
};

struct RockingSample {
  double time_s, theta, rate;
};

// theta'' = -p_i^2 [(1 + a_v/g) sin(alpha_i - theta) + gain_i (a_h/g) cos(alpha_i - theta)], i the toe that carries
// (fragility.md 2.2 for two toes). Dormand-Prince 5(4), steps within the record's own, impacts on its dense output;
// an impact multiplies the rate by eta; a body that would rise by less than 1e-6 of its toppling angle
// comes to rest. The start of rocking is solved exactly. After the record the outcome follows from energy, without
// integration. No slip, no bounce, no motion out of the plane.
// history: where given, receives the state at every step. Cost about 0.2 microseconds a sample while rocking.
// Throws invalid_argument for a profile or a record that does not fit.
[[nodiscard]] RockingResult rock(const RockingProfile& profile, const RockingInput& input,
                                 const RockingOptions& options = {}, std::vector<RockingSample>* history = nullptr);

}  // namespace cairn::fragility
