#include "fragility/published_model.hpp"

#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "fragility/tipping.hpp"

namespace cairn::fragility {
namespace {

using base::Error;
using base::ErrorCode;

double coefficient(const survey::FragilityModel& model, const char* name) {
  const auto found = model.coefficients.find(name);
  if (found == model.coefficients.end())
    throw Error(ErrorCode::failed_precondition, "model " + model.name + ": coefficient " + name + " is not supplied")
        .hint("Enter it in the model's file from the publication");
  return found->second;
}

void require_valid(const survey::FragilityModel& model, const char* name, double value) {
  const auto range = model.valid.find(name);
  if (range == model.valid.end() || (value >= range->second[0] && value <= range->second[1])) return;
  throw Error(ErrorCode::failed_precondition, "model " + model.name + ": " + name + " lies outside its range")
      .found(base::to_text(value))
      .allowed(base::to_text(range->second[0]) + " to " + base::to_text(range->second[1]));
}

}  // namespace

double published_probability(const survey::FragilityModel& model, double alpha, double r, double p, double pga_g,
                             double pgv_over_pga_s) {
  if (model.coefficients.empty())
    throw Error(ErrorCode::failed_precondition, "model " + model.name + ": coefficients not supplied")
        .hint("Enter them in the model's file from " + (model.doi.empty() ? model.reference : model.doi));
  require_valid(model, "alpha_rad", alpha);
  require_valid(model, "r_m", r);
  require_valid(model, "pga_g", pga_g);
  require_valid(model, "pgv_over_pga_s", pgv_over_pga_s);
  if (model.form == "logistic_ln_pga_ln_ratio") {
    const double x = coefficient(model, "b0") + coefficient(model, "b1") * std::log(pga_g) +
                     coefficient(model, "b2") * std::log(pgv_over_pga_s);
    return 1.0 / (1.0 + std::exp(-x));
  }
  if (model.form == "lognormal_p_pgv") {
    const double demand = p * pga_g * pgv_over_pga_s / std::tan(alpha);  // p PGV / (g tan alpha)
    const double z = std::log(demand / coefficient(model, "median")) / coefficient(model, "beta");
    return 0.5 * std::erfc(-z / std::numbers::sqrt2);
  }
  throw Error(ErrorCode::failed_precondition, "model " + model.name + ": its form is not known")
      .found(model.form)
      .allowed("logistic_ln_pga_ln_ratio, lognormal_p_pgv");
}

}  // namespace cairn::fragility
