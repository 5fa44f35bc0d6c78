// From a computed edge to its record.
#pragma once

#include "fragility/tipping.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

[[nodiscard]] inline survey::TippingEdge record_of(const Edge& e) {
  return {e.azimuth_deg,      e.alpha, e.r, e.p, e.a_qs_g, e.v_min, e.inclination, e.inertia_per_mass,
          e.barrier_per_mass, e.ends,  0.0};
}

}  // namespace cairn::fragility
