#include "experiment_run.hpp"

#include <map>
#include <set>

#include "evaluation/detection_ap.hpp"
#include "evaluation/target_errors.hpp"
#include "evaluation/target_stages.hpp"
#include "io/survey_folder.hpp"
#include "io/tracks_csv.hpp"
#include "localisation/body_fit.hpp"
#include "localisation/locate.hpp"
#include "pipeline/track_stage.hpp"
#include "simulation/simulate.hpp"
#include "support/data.hpp"

namespace cairn::acceptance {
namespace {

using evaluation::BiasRemoval;
using io::Json;

// Precision and recall of the boxes at IoU 0.5; objects cut by the image or mostly hidden do not count.
Json score_detector(const simulation::Recording& recording) {
  std::map<survey::ObjectId, const survey::TruthObject*> objects;
  std::set<std::string> sought;
  for (const auto& object : recording.truth.objects) {
    objects[object.id] = &object;
    if (object.sought) sought.insert(object.object_class);
  }
  std::vector<evaluation::TrueRegion> truth;
  for (const auto& box : recording.truth.boxes) {
    const auto& object = *objects.at(box.object);
    if (sought.contains(object.object_class))
      truth.push_back({box.frame, object.object_class, box.box, !box.whole || box.visible_share < 0.5, false});
  }
  std::size_t tp = 0, fp = 0, fn = 0;
  for (const auto& c : evaluation::score_detections(recording.survey.detections, truth, {}).classes) {
    if (!sought.contains(c.object_class)) continue;
    tp += c.tp;
    fp += c.fp;
    fn += c.fn;
  }
  return Json::object({{"tp", tp}, {"fp", fp}, {"fn", fn}});
}

Json stages_json(const evaluation::StageScores& scores) {
  Json stages = Json::object();
  for (const auto& s : scores.stages) {
    std::map<std::string, std::size_t> reasons;
    for (const auto& entry : s.entries)
      if (entry.verdict != evaluation::Verdict::right) ++reasons[std::string(name_of(entry.verdict))];
    Json why = Json::object();
    for (const auto& [reason, count] : reasons) why.set(reason, count);
    stages.set(std::string(survey::name_of(s.stage)),
               Json::object({{"tp", s.tp}, {"fp", s.fp}, {"fn", s.fn}, {"false_by_reason", std::move(why)}}));
  }
  return stages;
}

Json errors_json(const evaluation::EstimatorScore& score) {
  Json list = Json::array();
  for (const auto& c : score.centres) {
    Json row = Json::object({{"object", c.object.value}, {"error_m", Json(c.error)}});
    if (c.nees) row.set("nees", *c.nees);
    for (const auto& cylinder : score.cylinders)
      if (cylinder.target == c.target) {
        row.set("iou", cylinder.iou).set("volume_ratio", cylinder.volume_ratio);
        if (cylinder.contained) row.set("contained", *cylinder.contained);
      }
    list.push(std::move(row));
  }
  return list;
}

// How many targets ended in each state.
Json states_json(const std::vector<survey::Target>& targets) {
  std::map<std::string, std::size_t> counts;
  for (const auto& target : targets) ++counts[std::string(survey::name_of(target.state))];
  Json out = Json::object();
  for (const auto& [state, count] : counts) out.set(state, count);
  return out;
}

std::vector<survey::TrackedBox> track(const survey::Survey& survey, std::int64_t emit_age, base::RunContext& ctx) {
  const testing::TempFolder folder;
  io::write_survey(survey, folder.path());
  pipeline::TrackStageOptions options;
  options.sort.preset = "paper";
  options.sort.emit_age = emit_age;
  static_cast<void>(pipeline::track_survey(folder.path(), folder / "tracks.csv", options, ctx));
  return io::read_tracks(folder / "tracks.csv", survey);
}

}  // namespace

Json run_seed(const simulation::Scene& scene, std::uint64_t seed, const RunOptions& options, base::RunContext& ctx) {
  ctx.seed = seed;
  const auto recording = simulation::simulate(scene, seed, ctx);
  const auto& survey = recording.survey;
  std::map<survey::ObjectId, std::vector<evaluation::SurfacePatch>> surfaces;
  for (std::size_t i = 0; i < recording.truth.objects.size(); ++i) {
    const auto& object = recording.truth.objects[i];
    if (object.sought) surfaces[object.id] = evaluation::exposed_surface(recording.shapes[i].body, object);
  }

  Json modes = Json::object();
  for (const auto& name : options.modes) {
    const std::string mode = name == "robust" ? "robust" : "paper";
    localisation::LocateOptions locate;
    locate.mode = mode;
    locate.min_depth_m = mode == "paper" ? 0.1 : options.min_depth_m;
    locate.max_depth_m = mode == "paper" ? options.paper_depth_m : options.max_depth_m;
    localisation::LocateResult located;
    if (options.tracks) {
      // The public code's tracker hands its predictions on for 99 frames; the paper does not speak of that.
      const auto tracks = track(survey, name == "paper_coasted" ? 99 : 0, ctx);
      located = localisation::locate(survey, localisation::Tracks(tracks), locate, ctx);
    } else {
      located = localisation::locate(survey, locate, ctx);
    }
    if (mode == "robust") localisation::refine_bodies(located, survey, {}, ctx);
    const auto stages = evaluation::score_stages(located.targets, survey.detections, recording.truth, {});
    Json result = Json::object({{"stages", stages_json(stages)}, {"targets", states_json(located.targets)}});
    for (const auto& [errors_name, bias] : {std::pair{"errors_raw", BiasRemoval::none},
                                            {"errors", BiasRemoval::survey},
                                            {"errors_target_bias", BiasRemoval::target}}) {
      if (mode == "paper") break;
      const auto errors = evaluation::score_errors(located.targets, stages, survey.detections, survey.frames,
                                                   recording.truth, surfaces, bias);
      result.set(errors_name,
                 Json::object({{"filter", errors_json(errors.filter)}, {"refined", errors_json(errors.refined)}}));
    }
    modes.set(name, std::move(result));
  }
  return Json::object({{"grade", options.grade},
                       {"seed", static_cast<std::int64_t>(seed)},
                       {"frames", survey.frames.size()},
                       {"detector", score_detector(recording)},
                       {"modes", std::move(modes)}});
}

}  // namespace cairn::acceptance
