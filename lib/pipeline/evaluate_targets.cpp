#include <map>

#include "base/error.hpp"
#include "evaluation/target_errors.hpp"
#include "io/ply.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "io/truth.hpp"
#include "pipeline/evaluate_inputs.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using evaluation::BiasRemoval;
using evaluation::EstimatorScore;
using evaluation::StageScore;
using evaluation::SurfacePatch;
using io::Json;

BiasRemoval bias_of(const std::string& name) {
  if (name == "survey") return BiasRemoval::survey;
  return name == "target" ? BiasRemoval::target : BiasRemoval::none;
}

std::map<survey::ObjectId, std::vector<SurfacePatch>> exposed_surfaces(const survey::Truth& truth,
                                                                       const fs::path& folder) {
  std::map<survey::ObjectId, std::vector<SurfacePatch>> surfaces;
  for (const auto& object : truth.objects) {
    if (!object.sought || object.mesh.empty()) continue;
    const auto path = io::resolve_reference(object.mesh, folder);
    surfaces[object.id] = evaluation::exposed_surface(io::read_ply_mesh(path).mesh, object);
  }
  return surfaces;
}

Json stage_json(const StageScore& s) {
  std::map<std::string, std::size_t> reasons;
  Json entries = Json::array(), missed = Json::array();
  for (const auto& e : s.entries) {
    if (e.verdict != evaluation::Verdict::right) ++reasons[std::string(name_of(e.verdict))];
    entries.push(Json::object({{"target", e.target.value},
                               {"frame", e.frame.value},
                               {"object", e.object.valid() ? Json(e.object.value) : Json()},
                               {"verdict", name_of(e.verdict)}}));
  }
  for (const auto id : s.missed) missed.push(id.value);
  Json by_reason = Json::object();
  for (const auto& [reason, count] : reasons) by_reason.set(reason, count);
  return Json::object({{"tp", s.tp},
                       {"fp", s.fp},
                       {"fn", s.fn},
                       {"precision", optional_json(s.precision())},
                       {"recall", optional_json(s.recall())},
                       {"false_by_reason", std::move(by_reason)},
                       {"missed", std::move(missed)},
                       {"entries", std::move(entries)}});
}

Json nees_json(const std::vector<double>& values) {
  if (values.empty()) return Json::object({{"count", 0}, {"mean", Json()}, {"band_95", Json()}});
  const auto band = evaluation::mean_nees_band(values.size());
  return Json::object({{"count", values.size()},
                       {"mean", evaluation::spread(values).mean},
                       {"median", evaluation::spread(values).median},
                       {"band_95", Json(Json::Array{band.low, band.high})}});
}

Json cylinder_json(const EstimatorScore& score) {
  std::vector<double> ious, ratios, contained;
  for (const auto& c : score.cylinders) {
    ious.push_back(c.iou);
    ratios.push_back(c.volume_ratio);
    if (c.contained) contained.push_back(*c.contained);
  }
  return Json::object({{"count", ious.size()},
                       {"iou", optional_json(evaluation::quantile(ious, 0.5))},
                       {"volume_ratio", optional_json(evaluation::quantile(ratios, 0.5))},
                       {"contained_share", optional_json(evaluation::quantile(contained, 0.5))},
                       {"contained_share_min", optional_json(evaluation::quantile(contained, 0.0))}});
}

// centre_error_m, horizontal_error_m, vertical_error_m, nees, cylinder: the same members for both estimators.
void add_errors(Json& into, const EstimatorScore& score) {
  into.set("centre_error_m", to_json(score.centre()))
      .set("horizontal_error_m", to_json(score.horizontal()))
      .set("vertical_error_m", to_json(score.vertical()))
      .set("nees", nees_json(score.nees()))
      .set("cylinder", cylinder_json(score));
}

Json located_json(const EstimatorScore& score) {
  Json list = Json::array();
  for (const auto& c : score.centres)
    list.push(Json::object({{"target", c.target.value},
                            {"object", c.object.value},
                            {"error_m", Json(c.error)},
                            {"nees", optional_json(c.nees)}}));
  return list;
}

void check_frame(const survey::Origin& targets, const survey::Origin& survey, const fs::path& path) {
  const auto& a = targets.position;
  const auto& b = survey.position;
  if (a.latitude_deg == b.latitude_deg && a.longitude_deg == b.longitude_deg && a.height_m == b.height_m) return;
  throw Error(ErrorCode::crs_mismatch, "the targets' local frame is not the survey's")
      .file(path.string())
      .hint("Give the truth of the survey that the targets were located in");
}

}  // namespace

Outcome evaluate_targets(const EvaluateInputs& in, const EvaluateOptions& options, base::RunContext& ctx) {
  require_path(in.result, "the result");
  require_path(in.truth, "the truth");
  const auto truth_path = truth_json(in.truth);
  if (!truth_path)
    throw Error(ErrorCode::invalid_input, "not the truth of a simulated survey")
        .file(in.truth.string())
        .allowed("truth.json, or the survey's folder");
  const fs::path targets_path = fs::is_directory(in.result) ? in.result / "targets.json" : in.result;
  require_path(targets_path, "the result");
  const fs::path survey_path = in.survey.empty() ? truth_path->parent_path() : in.survey;
  const io::TargetsFile file = io::read_targets(targets_path);
  const survey::Truth truth = io::read_truth(*truth_path);
  const survey::Survey survey = io::read_survey(survey_path);
  check_frame(file.frame, survey.manifest.origin, targets_path);

  const auto stages = evaluation::score_stages(file.targets, survey.detections, truth, options.stages);
  const auto errors =
      evaluation::score_errors(file.targets, stages, survey.detections, survey.frames, truth,
                               exposed_surfaces(truth, truth_path->parent_path()), bias_of(options.remove_bias));
  if (stages.without_history > 0)
    ctx.warn(std::to_string(stages.without_history) +
             " targets have no history: their stages are taken from their final state");
  Outcome outcome;
  Json& s = outcome.summary;
  Json by_stage = Json::object();
  for (const auto& stage : stages.stages) by_stage.set(std::string(survey::name_of(stage.stage)), stage_json(stage));
  s = Json::object({{"kind", "targets"},
                    {"targets", file.targets.size()},
                    {"targets_of_other_classes", stages.other_classes},
                    {"sought_objects", stages.sought.size()},
                    {"seen_whole_frames", stages.seen_whole},
                    {"targets_without_history", stages.without_history},
                    {"stages", std::move(by_stage)},
                    {"bias_removed", options.remove_bias},
                    {"mean_pose_bias_m", Json(errors.survey_bias)}});
  add_errors(s, errors.filter);
  s.set("located", located_json(errors.filter));
  Json refined = Json::object();
  add_errors(refined, errors.refined);
  refined.set("located", located_json(errors.refined));
  s.set("refined", std::move(refined));
  return outcome;
}

}  // namespace cairn::pipeline
