// Logistic fragility P = 1 / (1 + exp(-(b0 + b1 ln PGA + b2 ln(PGV/PGA)))) of outcomes of 0 and 1.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace cairn::fragility {

// One body under one motion.
struct ShakeOutcome {
  double pga_g = 0.0;           // of the motion as it acted, > 0
  double pgv_over_pga_s = 0.0;  // > 0
  bool toppled = false;
  std::size_t record = 0;  // motions of one record are not independent: they are drawn together
};

struct LogisticOptions {
  // Firth (1993): Jeffreys' prior, b stays finite and nearly unbiased where outcomes separate. Without it, maximum
  // likelihood: refused (fitted = false) where a plane parts the outcomes.
  bool firth = true;
  bool with_ratio = true;  // the term b2; left out anyway where ln(PGV/PGA) varies by less than 0.02
};

struct LogisticFit {
  bool fitted = false;
  std::string reason;  // where not fitted: no_outcomes, none_toppled, all_toppled, separable, not_converged
  std::array<double, 3> b{};
  bool with_ratio = false;
  bool separable = false;  // a line in (ln PGA, ln PGV/PGA) parts toppled from standing: the slope is the prior's
  std::size_t count = 0, toppled = 0;
  double log_likelihood = 0.0;

  [[nodiscard]] double probability(double pga_g, double pgv_over_pga_s) const;
  // PGA of probability 1/2; needs b1 > 0.
  [[nodiscard]] double median_pga_g(double pgv_over_pga_s) const;
};

// Newton with halved steps; cost linear in outcomes.
[[nodiscard]] LogisticFit fit_logistic(std::span<const ShakeOutcome> outcomes, const LogisticOptions& options = {});

// P at one motion with its bootstrap quantiles.
struct CurvePoint {
  double pga_g = 0.0, pgv_over_pga_s = 0.0;
  double p = 0.0;  // of the fit itself
  double p05 = 0.0, p16 = 0.0, p50 = 0.0, p84 = 0.0, p95 = 0.0;
};

// Whole records are drawn with replacement (their motions are not independent); a draw in which all or none topple
// counts as P = 1 or 0 everywhere. `draws` >= 20; keyed by seed. Throws invalid_argument where the fit failed or
// there are fewer than two records: one record says nothing about another.
[[nodiscard]] std::vector<CurvePoint> bootstrap_curve(std::span<const ShakeOutcome> outcomes, const LogisticFit& fit,
                                                      const LogisticOptions& options,
                                                      std::span<const std::array<double, 2>> pga_and_ratio,
                                                      std::size_t draws, std::uint64_t seed);

// Mean squared difference of predicted probability and outcome, 0..1.
[[nodiscard]] double brier_score(std::span<const double> probabilities, std::span<const ShakeOutcome> outcomes);

}  // namespace cairn::fragility
