// Average precision of detections: COCO's definition.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "survey/detection.hpp"

namespace cairn::evaluation {

// A true box. `ignored`: neither missed nor wrongly found. `crowd`: a region of many objects; any number of detections
// may fall into it without harm, overlap is then intersection over the detection's area. Crowd implies ignored.
struct TrueRegion {
  survey::FrameId image;
  std::string object_class;
  geometry::PixelBox box;
  bool ignored = false;
  bool crowd = false;
};

struct ApOptions {
  std::int64_t max_detections = 100;  // of one class in one image, those of the highest scores
  double min_score = 0.0;             // for precision and recall at IoU 0.5 only; AP takes all scores

  void visit(base::OptionVisitor& visitor) {
    visitor.integer("max-detections", max_detections, 1, 1'000'000,
                    "detections of a class in one image that are scored, highest first (COCO: 100)");
    visitor.real("min-score", min_score, 0.0, 1.0,
                 "lowest score counted for precision and recall at IoU 0.5 (AP takes all), 0..1");
  }
};

inline constexpr std::size_t kIouThresholds = 10;  // .50, .55 .. .95
[[nodiscard]] double iou_threshold(std::size_t index);

struct ClassAp {
  std::string object_class;
  std::size_t truths = 0;      // not ignored
  std::size_t detections = 0;  // all
  // Area under the interpolated precision-recall curve at each IoU threshold. Valid where truths > 0.
  std::array<double, kIouThresholds> ap{};
  std::size_t tp = 0, fp = 0, fn = 0;  // at IoU 0.5, scores >= min_score

  [[nodiscard]] double ap50() const { return ap[0]; }
  [[nodiscard]] double ap75() const { return ap[5]; }
  [[nodiscard]] double ap50_95() const;  // mean over .50 .. .95, COCO's AP
  [[nodiscard]] double ap50_90() const;  // mean over .50 .. .90: what paper B calls AP50:90
  [[nodiscard]] std::optional<double> precision() const;
  [[nodiscard]] std::optional<double> recall() const;
};

struct DetectionScores {
  std::vector<ClassAp> classes;  // every class of truth or detections, by name
  std::size_t images = 0;        // with truth or detections

  // Mean of `figure` over the classes that have truth (COCO leaves the others out); empty where none has.
  [[nodiscard]] std::optional<double> mean(double (ClassAp::*figure)() const) const;
};

// COCO's evaluation (Lin et al. 2014, pycocotools) of boxes of all areas: detections of a class in an image in
// descending score (ties keep the order given) take the free true box of greatest IoU >= threshold, true boxes before
// ignored ones; those that take an ignored one are left out. Over all images (ascending id) in descending score,
// precision is made monotone from the right and read at 101 recalls 0, .01 .. 1.
// Cost: for each image detections * truths * thresholds.
[[nodiscard]] DetectionScores score_detections(const std::vector<survey::Detection>& detections,
                                               const std::vector<TrueRegion>& truth, const ApOptions& options);

}  // namespace cairn::evaluation
