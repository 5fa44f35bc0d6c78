#include <algorithm>
#include <cmath>
#include <limits>

#include "evaluation/tracking_scores.hpp"
#include "geometry/assignment.hpp"

namespace cairn::evaluation {
namespace {

constexpr double kRounding = std::numeric_limits<double>::epsilon();

double alpha_of(std::size_t index) {
  return 0.05 * static_cast<double>(index + 1);
}

// Jaccard index of every pair of identities before unique matching: overlaps, each normalised by what competes for it.
std::vector<double> alignment(const Sequence& sequence) {
  const std::size_t columns = sequence.track_boxes.size();
  std::vector<double> potential(sequence.truth_boxes.size() * columns, 0.0);
  for (const auto& frame : sequence.frames) {
    std::vector<double> of_truth(frame.truth.size(), 0.0), of_track(frame.tracks.size(), 0.0);
    for (std::size_t i = 0; i < frame.truth.size(); ++i)
      for (std::size_t j = 0; j < frame.tracks.size(); ++j) {
        of_truth[i] += frame.at(i, j);
        of_track[j] += frame.at(i, j);
      }
    for (std::size_t i = 0; i < frame.truth.size(); ++i)
      for (std::size_t j = 0; j < frame.tracks.size(); ++j) {
        const double whole = of_truth[i] + of_track[j] - frame.at(i, j);
        if (whole > kRounding) potential[frame.truth[i] * columns + frame.tracks[j]] += frame.at(i, j) / whole;
      }
  }
  for (std::size_t i = 0; i < sequence.truth_boxes.size(); ++i)
    for (std::size_t j = 0; j < columns; ++j) {
      double& p = potential[i * columns + j];
      p /= static_cast<double>(sequence.truth_boxes[i] + sequence.track_boxes[j]) - p;
    }
  return potential;
}

double mean(const HotaScore& score, double (*figure)(const HotaScore::AtAlpha&)) {
  double sum = 0.0;
  for (const auto& at : score.alphas) sum += figure(at);
  return sum / static_cast<double>(HotaScore::kAlphas);
}

}  // namespace

double HotaScore::AtAlpha::det_a() const {
  return static_cast<double>(tp) / static_cast<double>(std::max<std::size_t>(1, tp + fp + fn));
}
double HotaScore::AtAlpha::hota() const {
  return std::sqrt(det_a() * ass_a);
}
double HotaScore::hota() const {
  return mean(*this, [](const AtAlpha& a) { return a.hota(); });
}
double HotaScore::det_a() const {
  return mean(*this, [](const AtAlpha& a) { return a.det_a(); });
}
double HotaScore::ass_a() const {
  return mean(*this, [](const AtAlpha& a) { return a.ass_a; });
}
double HotaScore::loc_a() const {
  return mean(*this, [](const AtAlpha& a) { return a.loc_a; });
}

HotaScore hota_score(const Sequence& sequence) {
  HotaScore score;
  const std::size_t rows = sequence.truth_boxes.size(), columns = sequence.track_boxes.size();
  const auto aligned = alignment(sequence);
  std::vector<std::vector<std::size_t>> matches(HotaScore::kAlphas, std::vector<std::size_t>(rows * columns, 0));
  std::array<double, HotaScore::kAlphas> overlap{};
  for (const auto& frame : sequence.frames) {
    const std::size_t n = frame.truth.size(), m = frame.tracks.size();
    std::vector<std::size_t> assigned(n, geometry::kUnassigned);
    if (n > 0 && m > 0) {
      std::vector<double> cost;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < m; ++j)
          cost.push_back(-aligned[frame.truth[i] * columns + frame.tracks[j]] * frame.at(i, j));
      assigned = geometry::assign(cost, n, m);
    }
    for (std::size_t a = 0; a < HotaScore::kAlphas; ++a) {
      std::size_t pairs = 0;
      for (std::size_t i = 0; i < n; ++i) {
        if (assigned[i] == geometry::kUnassigned || frame.at(i, assigned[i]) < alpha_of(a) - kRounding) continue;
        ++matches[a][frame.truth[i] * columns + frame.tracks[assigned[i]]];
        overlap[a] += frame.at(i, assigned[i]);
        ++pairs;
      }
      score.alphas[a].tp += pairs;
      score.alphas[a].fn += n - pairs;
      score.alphas[a].fp += m - pairs;
    }
  }
  for (std::size_t a = 0; a < HotaScore::kAlphas; ++a) {
    auto& at = score.alphas[a];
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j) {
        const auto tpa = static_cast<double>(matches[a][i * columns + j]);
        const auto of_truth = static_cast<double>(sequence.truth_boxes[i]);
        const auto of_track = static_cast<double>(sequence.track_boxes[j]);
        at.ass_a += tpa * tpa / std::max(1.0, of_truth + of_track - tpa);
        at.ass_re += tpa * tpa / std::max(1.0, of_truth);
        at.ass_pr += tpa * tpa / std::max(1.0, of_track);
      }
    const double tp = static_cast<double>(std::max<std::size_t>(1, at.tp));
    at.ass_a /= tp;
    at.ass_re /= tp;
    at.ass_pr /= tp;
    at.loc_a = at.tp == 0 ? 1.0 : overlap[a] / tp;
  }
  return score;
}

void add(HotaScore& sum, const HotaScore& score) {
  for (std::size_t a = 0; a < HotaScore::kAlphas; ++a) {
    auto& s = sum.alphas[a];
    const auto& o = score.alphas[a];
    const auto n = static_cast<double>(s.tp), m = static_cast<double>(o.tp);
    if (n + m > 0.0) {
      const auto weighted = [n, m](double x, double y) { return (n * x + m * y) / (n + m); };
      s.ass_a = weighted(s.ass_a, o.ass_a);
      s.ass_re = weighted(s.ass_re, o.ass_re);
      s.ass_pr = weighted(s.ass_pr, o.ass_pr);
      s.loc_a = weighted(s.loc_a, o.loc_a);
    } else {
      s.loc_a = 1.0;
    }
    s.tp += o.tp;
    s.fp += o.fp;
    s.fn += o.fn;
  }
}

}  // namespace cairn::evaluation
