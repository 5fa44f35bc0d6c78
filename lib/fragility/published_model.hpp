// Probabilities by a published model that is given as data.
#pragma once

#include "survey/fragility_model.hpp"

namespace cairn::fragility {

// Rock: alpha [rad], R [m], p [rad/s] of its critical edge. Motion: PGA [g], PGV/PGA [s]. Returns P in 0..1.
// Throws failed_precondition where coefficients are not supplied ("model NAME: coefficients not supplied") or not
// all there, where the form is not known, and where rock or motion lies outside the model's range: nothing is guessed.
[[nodiscard]] double published_probability(const survey::FragilityModel& model, double alpha, double r, double p,
                                           double pga_g, double pgv_over_pga_s);

}  // namespace cairn::fragility
