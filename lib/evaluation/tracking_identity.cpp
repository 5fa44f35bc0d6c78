#include "evaluation/tracking_scores.hpp"
#include "geometry/assignment.hpp"

namespace cairn::evaluation {
namespace {

double ratio(double part, double whole) {
  return whole > 0.0 ? part / whole : 0.0;
}

}  // namespace

double IdentityScore::idf1() const {
  return ratio(2.0 * static_cast<double>(idtp), static_cast<double>(2 * idtp + idfp + idfn));
}
double IdentityScore::precision() const {
  return ratio(static_cast<double>(idtp), static_cast<double>(idtp + idfp));
}
double IdentityScore::recall() const {
  return ratio(static_cast<double>(idtp), static_cast<double>(idtp + idfn));
}

IdentityScore identity_score(const Sequence& sequence, double iou_threshold) {
  const std::size_t rows = sequence.truth_boxes.size(), columns = sequence.track_boxes.size();
  // An assigned pair saves, against leaving both alone, twice the number of frames in which it overlaps: the least
  // idfp + idfn is the greatest sum of overlaps.
  std::vector<double> cost(rows * columns, 0.0);
  for (const auto& frame : sequence.frames)
    for (std::size_t i = 0; i < frame.truth.size(); ++i)
      for (std::size_t j = 0; j < frame.tracks.size(); ++j)
        if (frame.at(i, j) >= iou_threshold) cost[frame.truth[i] * columns + frame.tracks[j]] -= 1.0;
  IdentityScore score;
  if (rows > 0 && columns > 0) {
    const auto assigned = geometry::assign(cost, rows, columns);
    for (std::size_t i = 0; i < rows; ++i)
      if (assigned[i] != geometry::kUnassigned)
        score.idtp += static_cast<std::size_t>(-cost[i * columns + assigned[i]]);
  }
  score.idfn = sequence.truths - score.idtp;
  score.idfp = sequence.tracks - score.idtp;
  return score;
}

void add(IdentityScore& sum, const IdentityScore& score) {
  sum.idtp += score.idtp;
  sum.idfp += score.idfp;
  sum.idfn += score.idfn;
}

}  // namespace cairn::evaluation
