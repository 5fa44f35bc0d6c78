#include "evaluation/target_errors.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

namespace cairn::evaluation {
namespace {

using geometry::Mat3;
using geometry::Vec3;
using survey::FrameId;

// recorded - true position of each frame that both have.
std::unordered_map<FrameId, Vec3> position_errors(const std::vector<survey::Frame>& recorded,
                                                  const std::vector<survey::Frame>& truth) {
  std::unordered_map<FrameId, Vec3> known, errors;
  for (const auto& frame : truth) known[frame.id] = frame.T_world_camera.translation;
  for (const auto& frame : recorded)
    if (const auto found = known.find(frame.id); found != known.end())
      errors[frame.id] = frame.T_world_camera.translation - found->second;
  return errors;
}

std::optional<double> normalised(const Vec3& error, const Mat3& covariance) {
  const Eigen::LLT<Mat3> factor(covariance);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const double nees = error.dot(factor.solve(error));
  if (!std::isfinite(nees) || nees < 0.0) return std::nullopt;
  return nees;
}

void score_cylinder(EstimatorScore& score, survey::TargetId id, geometry::VerticalCylinder cylinder, const Vec3& bias,
                    const survey::TruthObject& object, const std::vector<SurfacePatch>* surface) {
  cylinder.axis -= bias.head<2>();
  cylinder.bottom -= bias.z();
  cylinder.top -= bias.z();
  CylinderScore s;
  s.target = id;
  s.iou = iou(cylinder, object.cylinder);
  const double smallest = volume(object.cylinder);
  s.volume_ratio = smallest > 0.0 ? volume(cylinder) / smallest : 0.0;
  if (surface != nullptr) s.contained = contained_share(*surface, cylinder);
  score.cylinders.push_back(s);
}

Spread spread_of(const std::vector<CentreError>& centres, double (*figure)(const Vec3&)) {
  std::vector<double> values;
  for (const auto& c : centres) values.push_back(figure(c.error));
  return spread(values);
}

}  // namespace

std::string_view name_of(Estimator estimator) {
  return estimator == Estimator::filter ? "filter" : "refined";
}

Spread EstimatorScore::centre() const {
  return spread_of(centres, [](const Vec3& e) { return e.norm(); });
}
Spread EstimatorScore::horizontal() const {
  return spread_of(centres, [](const Vec3& e) { return e.head<2>().norm(); });
}
Spread EstimatorScore::vertical() const {
  return spread_of(centres, [](const Vec3& e) { return std::abs(e.z()); });
}
std::vector<double> EstimatorScore::nees() const {
  std::vector<double> values;
  for (const auto& c : centres)
    if (c.nees) values.push_back(*c.nees);
  return values;
}

Vec3 mean_pose_bias(const std::vector<survey::Frame>& recorded, const std::vector<survey::Frame>& truth) {
  const auto errors = position_errors(recorded, truth);
  Vec3 sum = Vec3::Zero();
  std::size_t count = 0;
  for (const auto& frame : recorded)  // in the order of the frames: the same sum on every machine
    if (const auto found = errors.find(frame.id); found != errors.end()) {
      sum += found->second;
      ++count;
    }
  return count == 0 ? sum : Vec3(sum / static_cast<double>(count));
}

TargetErrors score_errors(const std::vector<survey::Target>& targets, const StageScores& stages,
                          const std::vector<survey::Detection>& detections, const std::vector<survey::Frame>& recorded,
                          const survey::Truth& truth,
                          const std::map<survey::ObjectId, std::vector<SurfacePatch>>& surfaces, BiasRemoval bias) {
  TargetErrors out;
  out.filter.estimator = Estimator::filter;
  out.refined.estimator = Estimator::refined;
  out.survey_bias = mean_pose_bias(recorded, truth.frames);
  const auto errors = position_errors(recorded, truth.frames);
  std::unordered_map<survey::DetectionId, FrameId> frame_of;
  for (const auto& detection : detections) frame_of[detection.id] = detection.frame;
  std::map<survey::ObjectId, const survey::TruthObject*> objects;
  for (const auto& object : truth.objects) objects[object.id] = &object;
  std::map<survey::TargetId, survey::ObjectId> right;
  for (const auto& entry : stages.stages[2].entries)
    if (entry.verdict == Verdict::right) right[entry.target] = entry.object;

  for (const auto& target : targets) {
    const auto found = right.find(target.id);
    const bool ended_well =
        target.state == survey::TargetState::converged || target.state == survey::TargetState::mapped;
    if (found == right.end() || !ended_well) continue;
    const survey::TruthObject& object = *objects.at(found->second);
    Vec3 offset = Vec3::Zero();
    if (bias == BiasRemoval::survey) offset = out.survey_bias;
    if (bias == BiasRemoval::target) {
      std::unordered_set<FrameId> seen;
      for (const auto id : target.detections) {
        const auto frame = frame_of.find(id);
        if (frame == frame_of.end() || !seen.insert(frame->second).second) continue;
        const auto error = errors.find(frame->second);
        if (error != errors.end()) offset += error->second;
      }
      if (!seen.empty()) offset /= static_cast<double>(seen.size());
    }
    const auto surface = surfaces.find(object.id);
    const auto* patches = surface == surfaces.end() ? nullptr : &surface->second;
    const auto score = [&](EstimatorScore& into, const Vec3& centre, const Mat3& covariance) {
      const Vec3 error = centre - offset - object.cylinder.centre();
      into.centres.push_back({target.id, object.id, error, normalised(error, covariance)});
    };
    score(out.filter, target.centre, target.covariance);
    if (target.bcylinder) score_cylinder(out.filter, target.id, *target.bcylinder, offset, object, patches);
    if (target.refined) {
      score(out.refined, target.refined->centre, target.refined->covariance);
      score_cylinder(out.refined, target.id, target.refined->cylinder, offset, object, patches);
    }
  }
  return out;
}

}  // namespace cairn::evaluation
