#include "fragility/logistic.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"

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

// The outcomes with their logarithms about the mean and a weight each.
struct Problem {
  Eigen::MatrixXd x;
  Eigen::VectorXd y, weight;
  double mean_pga = 0.0, mean_ratio = 0.0;
};

struct State {
  double objective = 0.0, likelihood = 0.0;
  Eigen::VectorXd score;
  Eigen::MatrixXd information;
  bool parted = false;  // every outcome lies on its side of the plane
};

State evaluate(const Problem& q, const Eigen::VectorXd& b, bool firth) {
  State s;
  const Eigen::VectorXd eta = q.x * b;
  const auto n = q.x.rows();
  Eigen::VectorXd p(n), v(n);
  s.parted = true;
  for (Eigen::Index i = 0; i < n; ++i) {
    p[i] = sigmoid(eta[i]);
    v[i] = q.weight[i] * p[i] * (1.0 - p[i]);
    s.likelihood += q.weight[i] * (q.y[i] * eta[i] - softplus(eta[i]));
    if (q.weight[i] > 0.0 && !(q.y[i] > 0.5 ? eta[i] > 0.0 : eta[i] < 0.0)) s.parted = false;
  }
  s.information = q.x.transpose() * v.asDiagonal() * q.x;
  Eigen::VectorXd residual = q.weight.cwiseProduct(q.y - p);
  s.objective = s.likelihood;
  if (firth) {
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(s.information);
    const Eigen::MatrixXd solved = ldlt.solve(q.x.transpose());
    for (Eigen::Index i = 0; i < n; ++i) residual[i] += v[i] * q.x.row(i).dot(solved.col(i)) * (0.5 - p[i]);
    const double determinant = s.information.determinant();
    s.objective += determinant > 0.0 ? 0.5 * std::log(determinant) : -std::numeric_limits<double>::infinity();
  }
  s.score = q.x.transpose() * residual;
  return s;
}

struct Solution {
  Eigen::VectorXd b;
  double likelihood = 0.0;
  bool converged = false, separable = false;
};

Solution solve(const Problem& q, bool firth) {
  Solution out;
  out.b = Eigen::VectorXd::Zero(q.x.cols());
  State s = evaluate(q, out.b, firth);
  constexpr int kIterations = 200;
  for (int i = 0; i < kIterations; ++i) {
    if (!firth && s.parted) {
      out.separable = true;
      return out;
    }
    Eigen::VectorXd step = s.information.ldlt().solve(s.score);
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
    s = std::move(next);
    if (step.norm() < 1e-10 * (1.0 + out.b.norm())) {
      out.converged = true;
      break;
    }
  }
  if (s.score.cwiseAbs().maxCoeff() < 1e-6) out.converged = true;
  out.likelihood = s.likelihood;
  return out;
}

bool varies(const Problem& q, Eigen::Index column) {
  constexpr double kLeast = 0.02;  // of a natural logarithm
  const double total = q.weight.sum();
  const double mean = q.weight.dot(q.x.col(column)) / total;
  const Eigen::VectorXd d = q.x.col(column).array() - mean;
  return std::sqrt(q.weight.dot(d.cwiseProduct(d)) / total) > kLeast;
}

Problem problem_of(std::span<const ShakeOutcome> outcomes) {
  Problem q;
  const auto n = static_cast<Eigen::Index>(outcomes.size());
  q.x.resize(n, 3);
  q.y.resize(n);
  q.weight = Eigen::VectorXd::Ones(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& o = outcomes[static_cast<std::size_t>(i)];
    if (!(o.pga_g > 0.0) || !(o.pgv_over_pga_s > 0.0))
      throw Error(ErrorCode::invalid_argument, "an outcome needs positive PGA and PGV/PGA");
    q.x.row(i) << 1.0, std::log(o.pga_g), std::log(o.pgv_over_pga_s);
    q.y[i] = o.toppled ? 1.0 : 0.0;
  }
  q.mean_pga = n > 0 ? q.x.col(1).mean() : 0.0;
  q.mean_ratio = n > 0 ? q.x.col(2).mean() : 0.0;
  q.x.col(1).array() -= q.mean_pga;
  q.x.col(2).array() -= q.mean_ratio;
  return q;
}

LogisticFit fit(Problem q, const LogisticOptions& options) {
  LogisticFit f;
  f.count = static_cast<std::size_t>(q.weight.sum() + 0.5);
  f.toppled = static_cast<std::size_t>(q.weight.dot(q.y) + 0.5);
  if (f.count == 0) return f.reason = "no_outcomes", f;
  if (f.toppled == 0) return f.reason = "none_toppled", f;
  if (f.toppled == f.count) return f.reason = "all_toppled", f;
  f.with_ratio = options.with_ratio && varies(q, 2);
  if (!f.with_ratio) q.x.conservativeResize(Eigen::NoChange, 2);
  const auto plain = solve(q, false);
  // Quasi-separation has no plane with every point strictly on its side, but no maximum either.
  f.separable = plain.separable || !plain.converged;
  if (f.separable && !options.firth) return f.reason = "separable", f;
  const auto best = options.firth ? solve(q, true) : plain;
  if (!best.converged) return f.reason = "not_converged", f;
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
      for (std::size_t i = 0; i < outcomes.size(); ++i)
        drawn.weight[static_cast<Eigen::Index>(i)] = times[index.at(outcomes[i].record)];
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
