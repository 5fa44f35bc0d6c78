#include <limits>

#include "evaluation/tracking_scores.hpp"
#include "geometry/assignment.hpp"

namespace cairn::evaluation {
namespace {

// What rounding may take from an IoU that equals the threshold.
constexpr double kRounding = std::numeric_limits<double>::epsilon();
constexpr std::size_t kNone = static_cast<std::size_t>(-1);
// Outweighs every sum of IoUs that one frame can have: pairs that were matched before come first.
constexpr double kKept = 1000.0;

double ratio(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

double ClearScore::mota() const {
  if (truths == 0) return 0.0;
  return 1.0 - static_cast<double>(fp + fn + id_switches) / static_cast<double>(truths);
}
double ClearScore::motp() const {
  return tp == 0 ? 0.0 : overlap_sum / static_cast<double>(tp);
}
double ClearScore::precision() const {
  return ratio(tp, tp + fp);
}
double ClearScore::recall() const {
  return ratio(tp, tp + fn);
}

ClearScore clear_score(const Sequence& sequence, double iou_threshold) {
  const std::size_t objects = sequence.truth_boxes.size();
  ClearScore score;
  score.truths = sequence.truths;
  score.objects = objects;
  std::vector<std::size_t> last(objects, kNone), before(objects, kNone);  // ever; in the frame before
  std::vector<std::size_t> matched(objects, 0), runs(objects, 0);
  for (const auto& frame : sequence.frames) {
    const std::size_t rows = frame.truth.size(), columns = frame.tracks.size();
    if (rows == 0 || columns == 0) {  // as TrackEval: the memory of the frame before stays
      score.fp += columns;
      score.fn += rows;
      continue;
    }
    std::vector<double> cost(rows * columns, 0.0);
    for (std::size_t i = 0; i < rows; ++i)
      for (std::size_t j = 0; j < columns; ++j)
        if (frame.at(i, j) >= iou_threshold - kRounding)
          cost[i * columns + j] = -frame.at(i, j) - (before[frame.truth[i]] == frame.tracks[j] ? kKept : 0.0);
    const auto assigned = geometry::assign(cost, rows, columns);
    std::vector<std::size_t> now(objects, kNone);
    std::size_t pairs = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      const std::size_t j = assigned[i];
      if (j == geometry::kUnassigned || !(cost[i * columns + j] < 0.0)) continue;
      const std::size_t object = frame.truth[i], track = frame.tracks[j];
      if (last[object] != kNone && last[object] != track) ++score.id_switches;
      if (before[object] == kNone) ++runs[object];
      last[object] = now[object] = track;
      ++matched[object];
      ++pairs;
      score.overlap_sum += frame.at(i, j);
    }
    before = std::move(now);
    score.tp += pairs;
    score.fp += columns - pairs;
    score.fn += rows - pairs;
  }
  for (std::size_t o = 0; o < objects; ++o) {
    const double share = ratio(matched[o], sequence.truth_boxes[o]);
    if (share > 0.8) ++score.mostly_tracked;
    else if (share < 0.2) ++score.mostly_lost;
    if (runs[o] > 0) score.fragmentations += runs[o] - 1;
  }
  return score;
}

void add(ClearScore& sum, const ClearScore& score) {
  sum.truths += score.truths;
  sum.tp += score.tp;
  sum.fp += score.fp;
  sum.fn += score.fn;
  sum.id_switches += score.id_switches;
  sum.objects += score.objects;
  sum.mostly_tracked += score.mostly_tracked;
  sum.mostly_lost += score.mostly_lost;
  sum.fragmentations += score.fragmentations;
  sum.overlap_sum += score.overlap_sum;
}

}  // namespace cairn::evaluation
