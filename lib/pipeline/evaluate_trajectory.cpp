#include <algorithm>
#include <map>

#include "base/error.hpp"
#include "io/survey_folder.hpp"
#include "io/truth.hpp"
#include "io/tum_trajectory.hpp"
#include "pipeline/evaluate_inputs.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using evaluation::Pairs;
using evaluation::StampedPose;
using io::Json;

struct Trajectory {
  enum class Kind { truth, survey, tum } kind = Kind::tum;
  std::vector<StampedPose> poses;
  std::vector<std::string> images;       // file name without folder and extension; "" = none
  std::optional<survey::Origin> origin;  // of the local frame
  std::optional<base::TimeBase> time_base;
};

Trajectory of_frames(const std::vector<survey::Frame>& frames, Trajectory::Kind kind) {
  Trajectory t;
  t.kind = kind;
  for (const auto& frame : frames) {
    t.poses.push_back({frame.time_ns, frame.id.value, frame.T_world_camera});
    t.images.push_back(fs::path(frame.image).stem().string());
  }
  return t;
}

Trajectory of_survey(const fs::path& folder) {
  const survey::Survey survey = io::read_survey(folder);
  Trajectory t = of_frames(survey.frames, Trajectory::Kind::survey);
  t.origin = survey.manifest.origin;
  t.time_base = survey.manifest.time_base;
  return t;
}

Trajectory read(const fs::path& path, bool as_truth) {
  if (as_truth)
    if (const auto truth = truth_json(path); truth) {
      Trajectory t = of_frames(io::read_truth(*truth).frames, Trajectory::Kind::truth);
      if (fs::exists(truth->parent_path() / "survey.json"))
        t.origin = io::read_survey(truth->parent_path()).manifest.origin;
      return t;
    }
  if (fs::is_directory(path)) return of_survey(path);
  if (path.filename() == "survey.json" || path.filename() == "frames.csv") return of_survey(path.parent_path());
  Trajectory t;
  for (const auto& pose : io::read_tum(path)) t.poses.push_back({pose.time_ns, -1, pose.T_world_body});
  t.images.resize(t.poses.size());
  return t;
}

bool named(const Trajectory& t) {
  return !t.images.empty() && std::none_of(t.images.begin(), t.images.end(), [](const auto& i) { return i.empty(); });
}

std::string pairing(const Trajectory& estimate, const Trajectory& truth, const std::string& asked) {
  if (asked != "auto") return asked;
  if (estimate.kind == Trajectory::Kind::tum || truth.kind == Trajectory::Kind::tum) return "time";
  if (truth.kind == Trajectory::Kind::survey && named(estimate) && named(truth)) return "image";
  return "id";
}

// Images become ids that both share.
void number_by_image(Trajectory& estimate, Trajectory& truth) {
  std::map<std::string, std::int64_t> numbers;
  for (auto* t : {&truth, &estimate})
    for (std::size_t i = 0; i < t->poses.size(); ++i)
      t->poses[i].id = t->images[i].empty()
                           ? -1
                           : numbers.emplace(t->images[i], static_cast<std::int64_t>(numbers.size())).first->second;
}

void check_frames(const Trajectory& estimate, const Trajectory& truth, const EvaluateInputs& in,
                  evaluation::Alignment alignment) {
  const bool placed = alignment == evaluation::Alignment::none || alignment == evaluation::Alignment::translation;
  if (!placed || !estimate.origin || !truth.origin) return;
  const auto& a = estimate.origin->position;
  const auto& b = truth.origin->position;
  if (a.latitude_deg == b.latitude_deg && a.longitude_deg == b.longitude_deg && a.height_m == b.height_m) return;
  throw Error(ErrorCode::crs_mismatch, "the two trajectories are in different local frames")
      .file(in.truth.string())
      .hint("Use --align se3, or give trajectories with one origin");
}

}  // namespace

Outcome evaluate_trajectory(const EvaluateInputs& in, const EvaluateOptions& options, base::RunContext& ctx) {
  require_path(in.result, "the result");
  require_path(in.truth, "the truth");
  Trajectory estimate = read(in.result, false), truth = read(in.truth, true);
  const auto alignment = evaluation::alignment_of(options.trajectory);
  check_frames(estimate, truth, in, alignment);
  const std::string match = pairing(estimate, truth, options.match);
  if (match == "image") number_by_image(estimate, truth);
  if (match == "time" && estimate.time_base == base::TimeBase::unknown)
    ctx.warn("the survey's time base is not known; its times are compared as they are");
  const Pairs pairs = match == "time" ? evaluation::pairs_by_time(estimate.poses, truth.poses, options.trajectory)
                                      : evaluation::pairs_by_id(estimate.poses, truth.poses);
  const auto errors = evaluation::score_trajectory(estimate.poses, truth.poses, pairs, options.trajectory);
  const auto& T = errors.T_truth_estimate;
  const auto q = geometry::quaternion(T.rotation);
  Json rpe = Json::object({{"delta", options.trajectory.delta},
                           {"delta_unit", options.trajectory.delta_unit},
                           {"pairs", errors.relative_pairs},
                           {"translation_m", to_json(errors.rpe_m)},
                           {"rotation_deg", to_json(errors.rpe_rotation_deg)}});
  Outcome outcome;
  outcome.summary = Json::object({{"kind", "trajectory"},
                                  {"poses", estimate.poses.size()},
                                  {"truth_poses", truth.poses.size()},
                                  {"pairs", errors.pairs},
                                  {"match", match},
                                  {"align", options.trajectory.align},
                                  {"T_truth_estimate", Json::object({{"scale", T.scale},
                                                                     {"qw", q.qw},
                                                                     {"qx", q.qx},
                                                                     {"qy", q.qy},
                                                                     {"qz", q.qz},
                                                                     {"translation_m", Json(T.translation)}})},
                                  {"ate", to_json(errors.ate_m, "_m")},
                                  {"ate_rotation_deg", to_json(errors.ate_rotation_deg)},
                                  {"rpe", std::move(rpe)}});
  return outcome;
}

}  // namespace cairn::pipeline
