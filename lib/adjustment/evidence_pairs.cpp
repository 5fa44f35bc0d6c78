#include "adjustment/evidence_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "adjustment/ground_plane_fit.hpp"
#include "adjustment/pose_hypotheses.hpp"
#include "adjustment/robust.hpp"

namespace cairn::adjustment {
namespace {

constexpr std::array<int, 4> kTurns{0, 90, 180, 270};
using TurnCosts = std::array<std::array<double, 4>, 4>;  // [turn of a][turn of b]: disagreement / base line

struct Pair {
  std::size_t a = 0, b = 0;  // indices into survey.frames
  std::vector<PixelMatch> matches;
  double baseline_m = 0.0;
  TurnCosts cost{};
};

PoseHypothesis turned(int deg) {
  PoseHypothesis h;
  h.turned_deg = deg;
  return h;
}

class Solver {
 public:
  Solver(const survey::Survey& survey, const PairEvidenceOptions& options) : survey_(survey), options_(options) {}

  void add(const MatchedPair& matched) {
    const auto a = index_of(matched.a), b = index_of(matched.b);
    if (a == survey_.frames.size() || b == survey_.frames.size() || matched.matches.size() < 3) return;
    if (camera_of(a) == nullptr || camera_of(b) == nullptr) return;
    Pair pair;
    pair.a = a;
    pair.b = b;
    pair.baseline_m =
        (survey_.frames[a].T_world_camera.translation - survey_.frames[b].T_world_camera.translation).norm();
    if (!(pair.baseline_m >= options_.min_baseline_m)) return;
    const auto most = static_cast<std::size_t>(options_.max_matches);
    const std::size_t count = std::min(most, matched.matches.size());
    for (std::size_t i = 0; i < count; ++i) pair.matches.push_back(matched.matches[i * matched.matches.size() / count]);
    pairs_.push_back(std::move(pair));
  }

  [[nodiscard]] const std::vector<Pair>& pairs() const { return pairs_; }

  [[nodiscard]] GroundPlaneFit fit(const Pair& pair, const PoseHypothesis& of_a, const PoseHypothesis& of_b) const {
    const GroundView a{camera_of(pair.a), of_a.apply(survey_.frames[pair.a].T_world_camera)};
    const GroundView b{camera_of(pair.b), of_b.apply(survey_.frames[pair.b].T_world_camera)};
    return fit_ground_plane(a, b, pair.matches, options_.min_height_m, options_.max_height_m);
  }

  // Turn (index into kTurns) of each frame.
  [[nodiscard]] std::vector<std::size_t> solve_turns() {
    const std::size_t n = survey_.frames.size();
    std::vector<std::array<double, 4>> votes(n, {0.0, 0.0, 0.0, 0.0});
    for (auto& pair : pairs_) {
      std::size_t best_a = 0, best_b = 0;
      for (std::size_t i = 0; i < kTurns.size(); ++i)
        for (std::size_t j = 0; j < kTurns.size(); ++j) {
          pair.cost[i][j] = std::min(1.0, fit(pair, turned(kTurns[i]), turned(kTurns[j])).median_m / pair.baseline_m);
          if (pair.cost[i][j] < pair.cost[best_a][best_b]) {
            best_a = i;
            best_b = j;
          }
        }
      votes[pair.a][best_a] += 1.0 - pair.cost[best_a][best_b];
      votes[pair.b][best_b] += 1.0 - pair.cost[best_a][best_b];
    }
    std::vector<std::size_t> label(n, 0);
    for (std::size_t i = 0; i < n; ++i)
      label[i] = static_cast<std::size_t>(std::max_element(votes[i].begin(), votes[i].end()) - votes[i].begin());
    constexpr int kRounds = 50;
    for (int round = 0; round < kRounds && improve(label); ++round) {
    }
    return label;
  }

  // Median over pairs of disagreement / base line with one hypothesis applied to all frames.
  [[nodiscard]] std::pair<double, double> common(const PoseHypothesis& hypothesis) const {
    std::vector<double> ratios, metres;
    for (const auto& pair : pairs_) {
      const double baseline = (hypothesis.apply(survey_.frames[pair.a].T_world_camera).translation -
                               hypothesis.apply(survey_.frames[pair.b].T_world_camera).translation)
                                  .norm();
      if (!(baseline > 0.0)) continue;
      const double m = fit(pair, hypothesis, hypothesis).median_m;
      ratios.push_back(m / baseline);
      metres.push_back(m);
    }
    return {ratios.empty() ? std::numeric_limits<double>::infinity() : median(ratios), median(metres)};
  }

 private:
  [[nodiscard]] std::size_t index_of(survey::FrameId id) const {
    const auto* frame = survey_.frame(id);
    return frame == nullptr ? survey_.frames.size() : static_cast<std::size_t>(frame - survey_.frames.data());
  }
  [[nodiscard]] const survey::Camera* camera_of(std::size_t frame) const {
    return survey_.camera(survey_.frames[frame].camera);
  }

  // One sweep in the order of the frames; whether any label changed.
  bool improve(std::vector<std::size_t>& label) const {
    bool changed = false;
    for (std::size_t i = 0; i < label.size(); ++i) {
      std::array<double, 4> cost{};
      for (const auto& pair : pairs_) {
        if (pair.a == i)
          for (std::size_t t = 0; t < 4; ++t) cost[t] += pair.cost[t][label[pair.b]];
        if (pair.b == i)
          for (std::size_t t = 0; t < 4; ++t) cost[t] += pair.cost[label[pair.a]][t];
      }
      constexpr double kLeastGain = 1e-9;
      const auto best = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
      if (cost[best] < cost[label[i]] - kLeastGain) {
        label[i] = best;
        changed = true;
      }
    }
    return changed;
  }

  const survey::Survey& survey_;
  const PairEvidenceOptions& options_;
  std::vector<Pair> pairs_;
};

struct FrameCosts {
  std::vector<double> before_m, after_m, before_ratio, after_ratio;
};

// The hypothesis that explains all frames at once, where the declared poses and turns do not.
std::optional<PairVerdict> common_convention(const survey::Survey& survey, const Solver& solver,
                                             const PairEvidenceOptions& options) {
  std::optional<PairVerdict> verdict;
  const auto declared = solver.common(PoseHypothesis{});
  int parts = 0;
  double best = std::numeric_limits<double>::infinity();
  for (const auto& hypothesis : pose_hypotheses()) {
    if (hypothesis.parts() == 0 || (verdict && hypothesis.parts() > parts)) continue;
    const auto [ratio, metres] = solver.common(hypothesis);
    if (!(ratio <= options.max_sound_ratio) || !(ratio < best)) continue;
    best = ratio;
    parts = hypothesis.parts();
    verdict = PairVerdict{hypothesis.code(), {}, declared.second, metres, hypothesis.meaning(), hypothesis.remedy()};
  }
  if (verdict)
    for (const auto& frame : survey.frames) verdict->frames.push_back(frame.id);
  return verdict;
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> neighbour_pairs(const survey::Survey& survey,
                                                                 const PairEvidenceOptions& options) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  const std::size_t n = survey.frames.size();
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t j = 0; j < n; ++j) {
      const double d =
          (survey.frames[i].T_world_camera.translation - survey.frames[j].T_world_camera.translation).norm();
      if (i != j && d >= options.min_baseline_m) near.emplace_back(d, j);
    }
    const std::size_t count = std::min(near.size(), static_cast<std::size_t>(options.neighbours));
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
    for (std::size_t k = 0; k < count; ++k)
      pairs.emplace_back(std::min(i, near[k].second), std::max(i, near[k].second));
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

PairEvidence pair_evidence(const survey::Survey& survey, std::span<const MatchedPair> matched,
                           const PairEvidenceOptions& options) {
  auto checked = options;
  base::validate(base::bind_options(checked), "pair evidence");
  PairEvidence evidence;
  Solver solver(survey, options);
  for (const auto& pair : matched) solver.add(pair);
  const auto label = solver.solve_turns();

  std::vector<FrameCosts> costs(survey.frames.size());
  std::vector<double> ratios_after;
  for (const auto& pair : solver.pairs()) {
    const auto before = solver.fit(pair, turned(0), turned(0));
    const auto after = solver.fit(pair, turned(kTurns[label[pair.a]]), turned(kTurns[label[pair.b]]));
    evidence.pairs.push_back({survey.frames[pair.a].id, survey.frames[pair.b].id, pair.matches.size(), pair.baseline_m,
                              before.median_m, after.median_m, after.plane_up_m, before.turn_deg});
    ratios_after.push_back(after.median_m / pair.baseline_m);
    for (const auto frame : {pair.a, pair.b}) {
      costs[frame].before_m.push_back(before.median_m);
      costs[frame].after_m.push_back(after.median_m);
      costs[frame].before_ratio.push_back(before.median_m / pair.baseline_m);
      costs[frame].after_ratio.push_back(after.median_m / pair.baseline_m);
    }
  }
  for (std::size_t i = 0; i < costs.size(); ++i)
    if (costs[i].after_ratio.empty()) evidence.unmatched.push_back(survey.frames[i].id);
  if (evidence.pairs.empty()) return evidence;

  if (median(ratios_after) > options.max_sound_ratio) {
    if (auto verdict = common_convention(survey, solver, options)) {
      evidence.verdicts.push_back(std::move(*verdict));
      return evidence;
    }
  }
  std::map<int, std::vector<std::size_t>> by_turn;
  for (std::size_t i = 0; i < costs.size(); ++i) {
    if (costs[i].after_ratio.empty()) continue;
    if (median(costs[i].after_ratio) > options.max_sound_ratio) {
      evidence.unexplained.push_back(survey.frames[i].id);
    } else if (label[i] != 0) {
      by_turn[kTurns[label[i]]].push_back(i);
    }
  }
  for (const auto& [deg, frames] : by_turn) {
    PairVerdict verdict{turned(deg).code(), {}, 0.0, 0.0, turned(deg).meaning(), turned(deg).remedy()};
    std::vector<double> before, after;
    for (const auto i : frames) {
      verdict.frames.push_back(survey.frames[i].id);
      before.push_back(median(costs[i].before_m));
      after.push_back(median(costs[i].after_m));
    }
    verdict.before_m = median(before);
    verdict.after_m = median(after);
    evidence.verdicts.push_back(std::move(verdict));
  }
  return evidence;
}

}  // namespace cairn::adjustment
