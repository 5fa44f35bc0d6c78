// How far located targets lie from the objects they are of.
#pragma once

#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "base/options.hpp"
#include "evaluation/cylinder_overlap.hpp"
#include "evaluation/statistics.hpp"
#include "evaluation/target_stages.hpp"
#include "survey/frame.hpp"

namespace cairn::evaluation {

// Which of a target's two answers: the points filter with its triangulated centre, or the fitted body.
enum class Estimator { filter, refined };
[[nodiscard]] std::string_view name_of(Estimator estimator);

// none: as they are. survey: less the mean of (recorded - true) camera position over all frames of the survey.
// target: less that mean over the frames of the target's own boxes (a bias that drifts during the flight).
enum class BiasRemoval { none, survey, target };

struct CentreError {
  survey::TargetId target;
  survey::ObjectId object;
  geometry::Vec3 error = geometry::Vec3::Zero();  // estimate - truth, local ENU, m
  // Normalised error squared e^T C^-1 e (3 degrees of freedom); empty where C is not positive definite.
  std::optional<double> nees;
};

struct CylinderScore {
  survey::TargetId target;
  double iou = 0.0;                 // with the true smallest cylinder
  double volume_ratio = 0.0;        // over that of the smallest; 0 where the latter is empty
  std::optional<double> contained;  // share of the exposed surface inside; empty where there is no mesh
};

struct EstimatorScore {
  Estimator estimator = Estimator::filter;
  std::vector<CentreError> centres;      // by target, as given
  std::vector<CylinderScore> cylinders;  // of those that have one

  [[nodiscard]] Spread centre() const;      // |error|
  [[nodiscard]] Spread horizontal() const;  // of east and north
  [[nodiscard]] Spread vertical() const;    // |up|
  [[nodiscard]] std::vector<double> nees() const;
};

struct TargetErrors {
  EstimatorScore filter, refined;
  geometry::Vec3 survey_bias = geometry::Vec3::Zero();  // mean of recorded - true camera position, m
};

// Mean of recorded - true position over the frames that both have; zero where there is none.
[[nodiscard]] geometry::Vec3 mean_pose_bias(const std::vector<survey::Frame>& recorded,
                                            const std::vector<survey::Frame>& truth);

// Scores the true entries of stage `converged` whose target ended converged or mapped (stages.stages[2], verdict
// right): centre against the middle of the axis of the true cylinder. `surfaces`: exposed surface of objects that have
// a mesh. Bias is subtracted from estimates (centres and cylinders).
[[nodiscard]] TargetErrors score_errors(const std::vector<survey::Target>& targets, const StageScores& stages,
                                        const std::vector<survey::Detection>& detections,
                                        const std::vector<survey::Frame>& recorded, const survey::Truth& truth,
                                        const std::map<survey::ObjectId, std::vector<SurfacePatch>>& surfaces,
                                        BiasRemoval bias);

}  // namespace cairn::evaluation
