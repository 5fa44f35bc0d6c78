// A published fragility model as data: what it is, and its coefficients where someone has entered them.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

namespace cairn::survey {

struct FragilityModel {
  std::string name;       // "purvance2008"
  std::string reference;  // citation
  std::string doi;
  // What the coefficients mean:
  //   logistic_ln_pga_ln_ratio   P = 1 / (1 + exp(-(b0 + b1 ln PGA[g] + b2 ln(PGV/PGA)[s])))
  //   lognormal_p_pgv            P = Phi(ln(p PGV / (g tan alpha) / median) / beta)
  std::string form;
  std::vector<std::string> im;                         // intensity measures: "PGA", "PGV_over_PGA"
  std::map<std::string, double> coefficients;          // empty: not supplied
  std::map<std::string, std::array<double, 2>> valid;  // of alpha_rad, r_m, pga_g, pgv_over_pga_s: least and greatest
  std::string entered_by, checked_against;  // who typed the coefficients, from what, and against which values
};

}  // namespace cairn::survey
