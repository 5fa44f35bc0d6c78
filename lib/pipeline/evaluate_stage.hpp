// Stage `evaluate`: results against their truth. Nothing is written; the summary is the result.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "evaluation/detection_ap.hpp"
#include "evaluation/target_stages.hpp"
#include "evaluation/trajectory.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

// What `result` and `truth` may be stands with each function. A path to truth.json may also be given as the folder of
// the simulated survey.
struct EvaluateInputs {
  std::filesystem::path result{}, truth{};
  std::string format = "auto", truth_format = "auto";  // of files of boxes: io::box_format_names(), auto = recognised
  std::vector<std::string> class_names{};              // of class numbers in `result`
  std::filesystem::path survey{};                      // targets: the survey they were located in; "" = beside truth
};

struct EvaluateOptions {
  evaluation::StageOptions stages;
  evaluation::ApOptions ap;
  evaluation::TrajectoryOptions trajectory;
  double iou = 0.5;                  // tracks, segmentation: least IoU of a match
  std::string classes;               // detections, tracks: only these, comma-separated; "" = see the functions
  std::string remove_bias = "none";  // targets: none, survey, target (evaluation::BiasRemoval)
  std::string match = "auto";        // trajectory: what pairs poses

  void visit(base::OptionVisitor& visitor) {
    visitor.text("classes", classes, "detections, tracks: score these classes only, comma-separated");
    visitor.real("iou", iou, 0.01, 1.0, "tracks, segmentation: least intersection over union of a match");
    visitor.choice("remove-bias", remove_bias, {"none", "survey", "target"},
                   "targets: take off the mean error of the recorded positions, of all frames or of each target's own");
    visitor.choice("match", match, {"auto", "id", "image", "time"}, "trajectory: what pairs poses");
    stages.visit(visitor);
    ap.visit(visitor);
    trajectory.visit(visitor);
  }
};

// result: a survey folder with detections, a detections.csv, or a file or folder of boxes. truth: truth.json, or boxes.
// Truth of a simulated survey: objects of the classes that are sought; those not whole in the image or less visible
// than min_visible_share are ignored. Where one side has no classes, classes do not count.
// Images are paired by frame id (survey and truth.json), else by file name without folder and extension, else by
// number. Summary: images, mean {ap50, ap75, ap50_95, ap50_90, precision, recall}, classes {NAME: {...}}.
Outcome evaluate_detections(const EvaluateInputs& in, const EvaluateOptions& options, base::RunContext& ctx);

// result: MOT results, a tracks.csv, or a folder of either (one a sequence). truth: gt.txt, truth.json, or a folder
// with NAME.txt, NAME/gt.txt or NAME/gt/gt.txt for each NAME.txt of the results. MOT truth with 9 columns (MOT16 on):
// class 1 is scored, boxes on classes 2, 7, 8, 12 (as TrackEval) and boxes flagged 0 are ignored, other classes left
// out; with 7 or 10 columns: a confidence of 0 is ignored. Summary: mota, motp, idf1, hota, det_a, ass_a, loc_a, tp,
// fp, fn, id_switches, mostly_tracked, ...; sequences.
Outcome evaluate_tracks(const EvaluateInputs& in, const EvaluateOptions& options, base::RunContext& ctx);

// result: the folder that `locate` wrote, or a targets.json. truth: truth.json.
// Summary: stages {generated, converging, converged, mapped: {tp, fp, fn, precision, recall}}, centre_error_m,
// cylinder, nees, refined {...}.
// Throws crs_mismatch where the targets' frame is not the survey's.
Outcome evaluate_targets(const EvaluateInputs& in, const EvaluateOptions& options, base::RunContext& ctx);

// result: a survey folder or a TUM trajectory. truth: truth.json, a survey folder or a TUM trajectory.
// Poses are paired by frame id where truth is truth.json, by image name where both are surveys that name images, by
// frame id where both are surveys, else by time.
// Summary: pairs, align, scale, ate {rmse_m, ...}, ate_rotation_deg, rpe {translation_m, rotation_deg}.
Outcome evaluate_trajectory(const EvaluateInputs& in, const EvaluateOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
