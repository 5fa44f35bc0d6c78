#include "fragility/logistic.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"
#include "geometry/vec.hpp"

namespace cairn::fragility {
namespace {

using base::Error;
using base::ErrorCode;

double sigmoid(double x) {
  return x >= 0.0 ? 1.0 / (1.0 + std::exp(-x)) : std::exp(x) / (1.0 + std::exp(x));
}

// ln(1 + exp(x)) without overflow.
double softplus(double x) {
  return x > 0.0 ? x + std::log1p(std::exp(-x)) : std::log1p(std::exp(x));
}

using geometry::Mat3;
using geometry::Vec3;

// The outcomes with their logarithms about the mean, and a weight each. Without the ratio its column is 0.
struct Problem {
  std::vector<Vec3> x;
  std::vector<double> y, weight;
  double mean_pga = 0.0, mean_ratio = 0.0;
  bool with_ratio = true;
};

struct State {
  double objective = 0.0, likelihood = 0.0;
  Vec3 score = Vec3::Zero();
  Mat3 information = Mat3::Zero();
  bool parted = true;  // every outcome lies on its side of the plane
};

State evaluate(const Problem& q, const Vec3& b, bool firth) {
  State s;
  const std::size_t n = q.x.size();
  std::vector<double> p(n), v(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (q.weight[i] == 0.0) continue;
    const double eta = q.x[i].dot(b);
    p[i] = sigmoid(eta);
    v[i] = q.weight[i] * p[i] * (1.0 - p[i]);
    s.likelihood += q.weight[i] * (q.y[i] * eta - softplus(eta));
    if (!(q.y[i] > 0.5 ? eta > 0.0 : eta < 0.0)) s.parted = false;
    s.information += v[i] * q.x[i] * q.x[i].transpose();
    s.score += q.weight[i] * (q.y[i] - p[i]) * q.x[i];
  }
  if (!q.with_ratio) s.information(2, 2) = 1.0;
  s.objective = s.likelihood;
  if (firth) {
    const double determinant = s.information.determinant();
    s.objective += determinant > 0.0 ? 0.5 * std::log(determinant) : -std::numeric_limits<double>::infinity();
    const Mat3 inverse = s.information.inverse();
    for (std::size_t i = 0; i < n; ++i)
      if (v[i] > 0.0) s.score += v[i] * q.x[i].dot(inverse * q.x[i]) * (0.5 - p[i]) * q.x[i];
  }
  return s;
}

struct Solution {
  Vec3 b = Vec3::Zero();
  double likelihood = 0.0;
  bool converged = false, separable = false;
};

Solution solve(const Problem& q, bool firth) {
  Solution out;
  State s = evaluate(q, out.b, firth);
  constexpr int kIterations = 200;
  for (int i = 0; i < kIterations; ++i) {
    if (!firth && s.parted) {
      out.separable = true;
      return out;
    }
    Vec3 step = s.information.inverse() * s.score;
    if (!step.allFinite()) return out;
    // Long steps of a flat likelihood are cut; then halved until the objective rises.
    constexpr double kLongest = 5.0;
    if (step.norm() > kLongest) step *= kLongest / step.norm();
    State next;
    bool rose = false;
    for (int half = 0; half < 40 && !rose; ++half) {
      next = evaluate(q, out.b + step, firth);
      rose = next.objective >= s.objective - 1e-12 * std::abs(s.objective);
      if (!rose) step *= 0.5;
    }
    if (!rose) break;
    out.b += step;
    s = next;
    if (step.norm() < 1e-10 * (1.0 + out.b.norm())) {
      out.converged = true;
      break;
    }
  }
  if (s.score.cwiseAbs().maxCoeff() < 1e-6) out.converged = true;
  out.likelihood = s.likelihood;
  return out;
}

bool ratio_varies(const Problem& q) {
  constexpr double kLeast = 0.02;  // of a natural logarithm
  double total = 0.0, sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < q.x.size(); ++i) {
    total += q.weight[i];
    sum += q.weight[i] * q.x[i][2];
    squares += q.weight[i] * q.x[i][2] * q.x[i][2];
  }
  return squares / total - (sum / total) * (sum / total) > kLeast * kLeast;
}

Problem problem_of(std::span<const ShakeOutcome> outcomes) {
  Problem q;
  for (const auto& o : outcomes) {
    if (!(o.pga_g > 0.0) || !(o.pgv_over_pga_s > 0.0))
      throw Error(ErrorCode::invalid_argument, "an outcome needs positive PGA and PGV/PGA");
    q.x.emplace_back(1.0, std::log(o.pga_g), std::log(o.pgv_over_pga_s));
    q.y.push_back(o.toppled ? 1.0 : 0.0);
    q.mean_pga += q.x.back()[1];
    q.mean_ratio += q.x.back()[2];
  }
  q.weight.assign(q.x.size(), 1.0);
  if (q.x.empty()) return q;
  q.mean_pga /= static_cast<double>(q.x.size());
  q.mean_ratio /= static_cast<double>(q.x.size());
  for (auto& x : q.x) x -= Vec3(0.0, q.mean_pga, q.mean_ratio);
  return q;
}

LogisticFit fit(Problem q, const LogisticOptions& options) {
  LogisticFit f;
  double count = 0.0, toppled = 0.0;
  for (std::size_t i = 0; i < q.x.size(); ++i) {
    count += q.weight[i];
    toppled += q.weight[i] * q.y[i];
  }
  f.count = static_cast<std::size_t>(count + 0.5);
  f.toppled = static_cast<std::size_t>(toppled + 0.5);
  if (f.count == 0) f.reason = "no_outcomes";
  else if (f.toppled == 0) f.reason = "none_toppled";
  else if (f.toppled == f.count) f.reason = "all_toppled";
  if (!f.reason.empty()) return f;
  f.with_ratio = q.with_ratio = options.with_ratio && ratio_varies(q);
  if (!f.with_ratio)
    for (auto& x : q.x) x[2] = 0.0;
  const auto plain = solve(q, false);
  // Quasi-separation has no plane with every point strictly on its side, but no maximum either.
  f.separable = plain.separable || !plain.converged;
  const auto best = options.firth ? solve(q, true) : plain;
  if (f.separable && !options.firth) f.reason = "separable";
  else if (!best.converged) f.reason = "not_converged";
  if (!f.reason.empty()) return f;
  f.b = {best.b[0] - best.b[1] * q.mean_pga, best.b[1], 0.0};
  if (f.with_ratio) {
    f.b[2] = best.b[2];
    f.b[0] -= best.b[2] * q.mean_ratio;
  }
  f.log_likelihood = best.likelihood;
  f.fitted = true;
  return f;
}

double quantile(const std::vector<double>& sorted, double q) {
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto i = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(i);
  return i + 1 < sorted.size() ? sorted[i] + share * (sorted[i + 1] - sorted[i]) : sorted[i];
}

}  // namespace

double LogisticFit::probability(double pga_g, double pgv_over_pga_s) const {
  return sigmoid(b[0] + b[1] * std::log(pga_g) + (with_ratio ? b[2] * std::log(pgv_over_pga_s) : 0.0));
}

double LogisticFit::median_pga_g(double pgv_over_pga_s) const {
  return std::exp(-(b[0] + (with_ratio ? b[2] * std::log(pgv_over_pga_s) : 0.0)) / b[1]);
}

LogisticFit fit_logistic(std::span<const ShakeOutcome> outcomes, const LogisticOptions& options) {
  return fit(problem_of(outcomes), options);
}

std::vector<CurvePoint> bootstrap_curve(std::span<const ShakeOutcome> outcomes, const LogisticFit& fitted,
                                        const LogisticOptions& options,
                                        std::span<const std::array<double, 2>> pga_and_ratio, std::size_t draws,
                                        std::uint64_t seed) {
  std::map<std::size_t, std::size_t> index;
  for (const auto& o : outcomes) index.emplace(o.record, index.size());
  if (!fitted.fitted || index.size() < 2 || draws < 20)
    throw Error(ErrorCode::invalid_argument, "a bootstrap needs a fit, two records and 20 draws");
  const Problem all = problem_of(outcomes);
  std::vector<std::vector<double>> p(draws, std::vector<double>(pga_and_ratio.size()));
  base::parallel_for(draws, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t d = begin; d < end; ++d) {
      base::Random random(seed, "fragility bootstrap", d);
      std::vector<double> times(index.size(), 0.0);
      for (std::size_t k = 0; k < times.size(); ++k) times[random.below(times.size())] += 1.0;
      Problem drawn = all;
      for (std::size_t i = 0; i < outcomes.size(); ++i) drawn.weight[i] = times[index.at(outcomes[i].record)];
      const auto f = fit(std::move(drawn), options);
      for (std::size_t k = 0; k < pga_and_ratio.size(); ++k)
        p[d][k] = f.fitted
                      ? f.probability(pga_and_ratio[k][0], pga_and_ratio[k][1])
                      : (f.reason == "all_toppled"    ? 1.0
                         : f.reason == "none_toppled" ? 0.0
                                                      : fitted.probability(pga_and_ratio[k][0], pga_and_ratio[k][1]));
    }
  });
  std::vector<CurvePoint> curve;
  for (std::size_t k = 0; k < pga_and_ratio.size(); ++k) {
    std::vector<double> values(draws);
    for (std::size_t d = 0; d < draws; ++d) values[d] = p[d][k];
    std::sort(values.begin(), values.end());
    const auto [pga, ratio] = pga_and_ratio[k];
    curve.push_back({pga, ratio, fitted.probability(pga, ratio), quantile(values, 0.05), quantile(values, 0.16),
                     quantile(values, 0.5), quantile(values, 0.84), quantile(values, 0.95)});
  }
  return curve;
}

double brier_score(std::span<const double> probabilities, std::span<const ShakeOutcome> outcomes) {
  if (probabilities.size() != outcomes.size() || outcomes.empty())
    throw Error(ErrorCode::invalid_argument, "a Brier score needs a probability an outcome");
  double sum = 0.0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    const double d = probabilities[i] - (outcomes[i].toppled ? 1.0 : 0.0);
    sum += d * d;
  }
  return sum / static_cast<double>(outcomes.size());
}

}  // namespace cairn::fragility
