#include "evaluation/detection_ap.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>

#include "evaluation/box_overlap.hpp"

namespace cairn::evaluation {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);
// Recalls and IoU thresholds to the last bit as numpy's linspace makes them: a recall of 7/20 does not reach 35 * 0.01.
constexpr int kRecallSteps = 100;
constexpr double kRecallStep = 0.01;

struct ImageClass {
  std::vector<const survey::Detection*> detections;
  std::vector<const TrueRegion*> truth;
};

struct Judged {
  double score = 0.0;
  bool hit = false;
};

double overlap(const survey::Detection& detection, const TrueRegion& truth) {
  if (!truth.crowd) return iou(detection.box, truth.box);
  const double area = detection.box.area();
  return area > 0.0 ? intersection(detection.box, truth.box) / area : 0.0;
}

bool ignored(const TrueRegion& truth) {
  return truth.ignored || truth.crowd;
}

// Detections sorted and cut, truth with the ignored last, and their overlaps: shared by all thresholds.
struct Prepared {
  std::vector<double> scores, overlaps;  // overlaps: detection major
  std::vector<char> ignored, crowd;
};

Prepared prepare(ImageClass image, std::size_t max_detections) {
  std::stable_sort(image.detections.begin(), image.detections.end(),
                   [](const auto* a, const auto* b) { return a->score > b->score; });
  if (image.detections.size() > max_detections) image.detections.resize(max_detections);
  std::stable_sort(image.truth.begin(), image.truth.end(),
                   [](const auto* a, const auto* b) { return ignored(*a) < ignored(*b); });
  Prepared p;
  for (const auto* t : image.truth) {
    p.ignored.push_back(ignored(*t) ? 1 : 0);
    p.crowd.push_back(t->crowd ? 1 : 0);
  }
  for (const auto* d : image.detections) {
    p.scores.push_back(d->score);
    for (const auto* t : image.truth) p.overlaps.push_back(overlap(*d, *t));
  }
  return p;
}

// Hits and misses of one image at one threshold, ignored ones left out, in descending score.
void match(const Prepared& p, double threshold, std::vector<Judged>& judged) {
  const std::size_t truths = p.ignored.size();
  std::vector<char> taken(truths, 0);
  for (std::size_t d = 0; d < p.scores.size(); ++d) {
    double best = std::min(threshold, 1.0 - 1e-10);
    std::size_t at = kNone;
    for (std::size_t t = 0; t < truths; ++t) {
      if (taken[t] != 0 && p.crowd[t] == 0) continue;
      if (at != kNone && p.ignored[at] == 0 && p.ignored[t] != 0) break;  // a true box goes before an ignored one
      if (p.overlaps[d * truths + t] < best) continue;
      best = p.overlaps[d * truths + t];
      at = t;
    }
    if (at != kNone) taken[at] = 1;
    if (at == kNone || p.ignored[at] == 0) judged.push_back({p.scores[d], at != kNone});
  }
}

double average_precision(const std::vector<Judged>& judged, std::size_t truths) {
  std::vector<double> recall, precision;
  std::size_t hits = 0;
  for (std::size_t i = 0; i < judged.size(); ++i) {
    hits += judged[i].hit ? 1U : 0U;
    recall.push_back(static_cast<double>(hits) / static_cast<double>(truths));
    precision.push_back(static_cast<double>(hits) / static_cast<double>(i + 1));
  }
  for (std::size_t i = precision.size(); i-- > 1;) precision[i - 1] = std::max(precision[i - 1], precision[i]);
  double sum = 0.0;
  for (int step = 0; step <= kRecallSteps; ++step) {
    const auto at = std::lower_bound(recall.begin(), recall.end(), step * kRecallStep);
    if (at != recall.end()) sum += precision[static_cast<std::size_t>(at - recall.begin())];
  }
  return sum / (kRecallSteps + 1.0);
}

ClassAp score_class(const std::map<survey::FrameId, ImageClass>& images, const ApOptions& options) {
  ClassAp score;
  std::vector<Prepared> prepared;
  for (const auto& [id, image] : images) {
    score.detections += image.detections.size();
    for (const auto* t : image.truth) score.truths += ignored(*t) ? 0U : 1U;
    prepared.push_back(prepare(image, static_cast<std::size_t>(options.max_detections)));
  }
  for (std::size_t k = 0; k < kIouThresholds; ++k) {
    std::vector<Judged> judged;
    for (const auto& p : prepared) match(p, iou_threshold(k), judged);
    std::stable_sort(judged.begin(), judged.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    if (score.truths > 0) score.ap[k] = average_precision(judged, score.truths);
    if (k > 0) continue;
    for (const auto& j : judged)
      if (j.score >= options.min_score) ++(j.hit ? score.tp : score.fp);
    score.fn = score.truths - score.tp;
  }
  return score;
}

}  // namespace

double iou_threshold(std::size_t index) {
  constexpr double kFirst = 0.5, kLast = 0.95;
  return kFirst + static_cast<double>(index) * ((kLast - kFirst) / static_cast<double>(kIouThresholds - 1));
}

double ClassAp::ap50_95() const {
  return std::accumulate(ap.begin(), ap.end(), 0.0) / static_cast<double>(ap.size());
}
double ClassAp::ap50_90() const {
  return std::accumulate(ap.begin(), ap.end() - 1, 0.0) / static_cast<double>(ap.size() - 1);
}
std::optional<double> ClassAp::precision() const {
  if (tp + fp == 0) return std::nullopt;
  return static_cast<double>(tp) / static_cast<double>(tp + fp);
}
std::optional<double> ClassAp::recall() const {
  if (tp + fn == 0) return std::nullopt;
  return static_cast<double>(tp) / static_cast<double>(tp + fn);
}

std::optional<double> DetectionScores::mean(double (ClassAp::*figure)() const) const {
  double sum = 0.0;
  std::size_t count = 0;
  for (const auto& c : classes)
    if (c.truths > 0) {
      sum += (c.*figure)();
      ++count;
    }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

DetectionScores score_detections(const std::vector<survey::Detection>& detections, const std::vector<TrueRegion>& truth,
                                 const ApOptions& options) {
  std::map<std::string, std::map<survey::FrameId, ImageClass>> classes;
  std::set<survey::FrameId> images;
  for (const auto& t : truth) {
    classes[t.object_class][t.image].truth.push_back(&t);
    images.insert(t.image);
  }
  for (const auto& d : detections) {
    classes[d.object_class][d.frame].detections.push_back(&d);
    images.insert(d.frame);
  }
  DetectionScores scores;
  scores.images = images.size();
  for (const auto& [name, boxes] : classes) {
    scores.classes.push_back(score_class(boxes, options));
    scores.classes.back().object_class = name;
  }
  return scores;
}

}  // namespace cairn::evaluation
