// Stage `evaluate segmentation`: a labelled cloud, its contact lines and bodies against what is true of them.
#pragma once

#include <filesystem>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

struct EvaluateSegmentationInputs {
  std::filesystem::path labelled{};  // cloud with columns label and target_id, as `segment` writes it
  std::filesystem::path truth{};     // cloud of the same points with the true columns
  // Contact lines in the cloud's coordinates. "" = X.contact.csv beside X.las, else those of the bodies.
  std::filesystem::path contact{};
  // Folder that `surface` or `fragility` wrote (then volume and alpha are its own), or a rocks.json. "" = bodies are
  // made here by the surface stage's defaults where the truth has volumes.
  std::filesystem::path rocks{};
  // truth.json with rims, volumes and centres of mass in the cloud's coordinates. "" = truth.json in the folder of the
  // truth's name without .las, else beside it, where there is one.
  std::filesystem::path truth_rocks{};
};

struct EvaluateSegmentationOptions {
  double least_iou = 0.5;      // of a rock that counts as found
  double tolerance_m = 0.002;  // points of the two clouds nearer than this are the same
  double step_m = 0.005;       // along contact lines
  void visit(base::OptionVisitor& visitor);
};

// Nothing is written. Summary: points, unpaired, iou, dice, precision, recall (of rock: labels 2 and 4), classes,
// instances {true, found, matched, precision, recall, mean_iou}, contact {mean_m, p95_m, hausdorff_m: spreads},
// alpha_error_deg, contact_alpha_error_deg, volume_error_share (spreads of absolute errors), rocks: one entry a true
// rock. alpha_error_deg: of the critical edge, rock's own centre of mass and contact against the true rim;
// contact_alpha_error_deg: true centre of mass with the found contact.
// Clouds are paired by order where all points agree within the tolerance, else by nearest point; true points without a
// partner count as found label 0, found points without one as unpaired.
[[nodiscard]] Outcome evaluate_segmentation(const EvaluateSegmentationInputs& in,
                                            const EvaluateSegmentationOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
