#include "pipeline/refine_stage.hpp"

#include <cmath>

#include "adjustment/bundle.hpp"
#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/projection_jacobian.hpp"
#include "io/control_points.hpp"
#include "io/csv.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/match_images.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using adjustment::BundleResult;
using io::Json;

// The frame with its whole uncertainty, what all frames have in common included.
survey::Frame with_common_errors(const BundleResult& result, std::size_t index) {
  survey::Frame frame = result.frames[index];
  const auto& c = result.frame_reports[index].covariance;
  if (c.isZero(0.0)) return frame;
  frame.sigma_xy_m = std::sqrt(0.5 * (c(3, 3) + c(4, 4)));
  frame.sigma_z_m = std::sqrt(c(5, 5));
  frame.sigma_rot_deg = base::rad_to_deg(std::sqrt(c.topLeftCorner<3, 3>().trace() / 3.0));
  return frame;
}

void write_frames(const fs::path& path, const BundleResult& result) {
  io::CsvWriter csv(path, {"frame_id", "state", "observations", "outliers", "rms_before_px", "rms_after_px", "moved_m",
                           "turned_deg", "prior_sigmas", "sigma_xy_m", "sigma_z_m", "sigma_rot_deg"});
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    const auto& report = result.frame_reports[i];
    const auto frame = with_common_errors(result, i);
    csv.cell(frame.id.value)
        .cell(report.reason.empty() ? "adjusted" : report.reason)
        .cell(static_cast<std::uint64_t>(report.observations))
        .cell(static_cast<std::uint64_t>(report.outliers))
        .cell(report.rms_before_px)
        .cell(report.rms_after_px)
        .cell(report.moved_m)
        .cell(report.turned_deg)
        .cell(report.prior_sigmas)
        .cell(frame.sigma_xy_m)
        .cell(frame.sigma_z_m)
        .cell(frame.sigma_rot_deg);
    csv.end_row();
  }
  csv.finish();
}

Json frames_json(const BundleResult& result) {
  Json frames = Json::array();
  for (std::size_t i = 0; i < result.frames.size(); ++i) {
    const auto& r = result.frame_reports[i];
    const auto frame = with_common_errors(result, i);
    frames.push(Json::object({{"frame", frame.id.value},
                              {"state", r.reason.empty() ? "adjusted" : r.reason},
                              {"observations", r.observations},
                              {"outliers", r.outliers},
                              {"rms_before_px", r.rms_before_px},
                              {"rms_after_px", r.rms_after_px},
                              {"moved_m", r.moved_m},
                              {"turned_deg", r.turned_deg},
                              {"prior_sigmas", r.prior_sigmas},
                              {"prior_doubted", r.prior_doubted},
                              {"sigma_xy_m", frame.sigma_xy_m},
                              {"sigma_z_m", frame.sigma_z_m},
                              {"sigma_rot_deg", frame.sigma_rot_deg}}));
  }
  return frames;
}

Json rounds_json(const BundleResult& result) {
  Json rounds = Json::array();
  for (const auto& r : result.rounds)
    rounds.push(Json::object({{"iterations", r.iterations},
                              {"cost_before", r.cost_before},
                              {"cost_after", r.cost_after},
                              {"sigma_px", r.sigma_px},
                              {"observations", r.observations},
                              {"removed", r.removed},
                              {"converged", r.converged},
                              {"termination", r.termination}}));
  return rounds;
}

Json control_json(const BundleResult& result) {
  Json points = Json::array();
  for (const auto& c : result.control)
    points.push(Json::object({{"name", c.name},
                              {"use", c.check_only ? "check" : "control"},
                              {"reason", c.reason},
                              {"observations", c.observations},
                              {"before_m", c.before},
                              {"after_m", c.after},
                              {"rms_px", c.rms_px}}));
  return points;
}

Json camera_json(const survey::Camera& c) {
  return Json::object({{"camera", c.id.value},
                       {"fx_px", c.fx_px},
                       {"fy_px", c.fy_px},
                       {"cx_px", c.cx_px},
                       {"cy_px", c.cy_px},
                       {"k1", c.k1},
                       {"k2", c.k2},
                       {"k3", c.k3},
                       {"k4", c.k4},
                       {"p1", c.p1},
                       {"p2", c.p2}});
}

Json summary_of(const survey::Survey& before, const BundleResult& result) {
  Json json = Json::object({{"frames", result.frames.size()},
                            {"frames_adjusted", result.frames_adjusted},
                            {"points", result.points},
                            {"observations", result.observations},
                            {"gauge", adjustment::name_of(result.gauge)},
                            {"converged", result.converged},
                            {"rms_before_px", result.rms_before_px},
                            {"rms_after_px", result.rms_after_px},
                            {"sigma_px", result.sigma_px},
                            {"covariance", result.covariance_method}});
  if (result.gauge == adjustment::BundleGauge::aligned)
    json.set(
        "alignment",
        Json::object({{"scale", result.alignment.scale},
                      {"turned_deg", geometry::rotation_angle(result.alignment.rotation) * 180.0 / std::numbers::pi}}));
  json.set("rounds", rounds_json(result));
  json.set("frame_table", frames_json(result));
  json.set("control_points", control_json(result));
  Json cameras = Json::array();
  for (std::size_t i = 0; i < result.cameras.size(); ++i)
    if (!(result.cameras[i] == before.manifest.cameras[i]))
      cameras.push(Json::object(
          {{"before", camera_json(before.manifest.cameras[i])}, {"after", camera_json(result.cameras[i])}}));
  json.set("cameras_changed", std::move(cameras));
  json.set("rejects_by_reason", count_by_reason(result.rejects));
  return json;
}

// References of a survey that moves to another folder.
void move_references(survey::Survey& survey, const fs::path& from, const fs::path& to) {
  const auto moved = [&](const std::string& reference) {
    return reference.empty() ? reference : io::file_reference(io::resolve_reference(reference, from), to);
  };
  for (auto& frame : survey.frames) frame.image = moved(frame.image);
  for (auto& source : survey.manifest.sources) source.path = moved(source.path);
}

std::string datum_text(adjustment::BundleGauge gauge) {
  switch (gauge) {
    case adjustment::BundleGauge::priors: return "position, attitude and scale by the frames' sigmas";
    case adjustment::BundleGauge::control: return "position, attitude and scale by control points";
    case adjustment::BundleGauge::aligned: return "aligned by a similarity to the positions before";
  }
  return "";
}

survey::Survey refined(const survey::Survey& before, const BundleResult& result) {
  survey::Survey after = before;
  after.frames = result.frames;
  for (auto& frame : after.frames) frame.T_world_camera = io::exact_pose(frame.T_world_camera);
  after.manifest.cameras = result.cameras;
  after.ties = result.ties;
  const std::string how = "Refined by bundle adjustment of " + std::to_string(result.points) + " tie points; " +
                          datum_text(result.gauge) + ".";
  for (auto& source : after.manifest.sources)
    if (source.kind == "poses") source.convention += (source.convention.empty() ? "" : " ") + how;
  after.manifest.notes.push_back(how +
                                 " The frames' sigmas are those of the adjustment: they contain the priors, and "
                                 "refining this survey again would count the same evidence twice.");
  return after;
}

}  // namespace

namespace {

// Matched images come from cameras that nobody calibrated: their distortion is found with the poses, their focal length
// where the views tell it from the height. A camera without distortion terms gets them.
void free_intrinsics(bool one_height, adjustment::BundleOptions& bundle, survey::Survey& survey) {
  if (bundle.intrinsics == "auto") bundle.intrinsics = one_height ? "distortion" : "radial";
  if (bundle.intrinsics == "none" || bundle.intrinsics == "focal") return;
  for (auto& camera : survey.manifest.cameras)
    if (camera.model == survey::CameraModel::pinhole) camera.model = survey::CameraModel::radial;
}

}  // namespace

Outcome refine_stage(const RefineInputs& in, const fs::path& out, const RefineStageOptions& options,
                     base::RunContext& ctx) {
  survey::Survey survey = io::read_survey(in.survey);
  Json matching;
  std::vector<base::Reject> rejects;
  std::vector<geometry::RigidTransform> start;
  auto bundle = options.bundle;
  if (options.match) {
    auto matched = match_images(std::move(survey), in.survey, options.matching, ctx);
    survey = std::move(matched.survey);
    matching = std::move(matched.summary);
    rejects = std::move(matched.matching.rejects);
    free_intrinsics(matched.one_height, bundle, survey);
    for (const auto& frame : matched.matching.start) start.push_back(frame.T_world_camera);
    // One compass and one mount turn all frames alike: the positions know the survey's azimuth better than the mean of
    // its headings, and the images know the rest.
    constexpr double kMatchedPriorDeg = 30.0;
    if (bundle.prior_sigma_rot_deg == 0.0) bundle.prior_sigma_rot_deg = kMatchedPriorDeg;
  }
  if (survey.ties.empty())
    throw base::Error(base::ErrorCode::failed_precondition, "the survey has no tie points")
        .file((in.survey / "tie_points.csv").string())
        .hint("Find them in the images with --match, or import a model that has them");
  io::ControlPoints control;
  if (!in.control.empty())
    control = io::read_control_points(in.control, survey,
                                      {.crs = options.control_crs, .image_scale = options.control_image_scale});
  rejects.insert(rejects.end(), control.rejects.begin(), control.rejects.end());
  std::size_t observations = 0;
  for (const auto& tie : survey.ties) observations += tie.observations.size();
  constexpr std::uint64_t kBytesPerObservation = 700;
  ctx.check_memory(observations * kBytesPerObservation, "the bundle adjustment");
  const BundleResult result = adjustment::adjust_bundle(
      {survey.manifest.cameras, survey.frames, start, survey.ties, control.points}, bundle, ctx);
  if (!result.converged)
    ctx.warn(
        "the adjustment stopped at a limit, not at a minimum: look at the residuals, raise --max-rounds or "
        "--max-iterations");
  for (const auto& point : result.control)
    if (!point.reason.empty()) ctx.warn("control point " + point.name + " is not used: " + point.reason);
  survey::Survey after = refined(survey, result);
  if (!in.control.empty()) {
    survey::Source source;
    source.kind = "control_points";
    source.path = fs::absolute(in.control).string();
    source.convention = control.convention;
    source.crs = control.crs;
    after.manifest.sources.push_back(std::move(source));
  }
  move_references(after, in.survey, in.final_folder);
  io::write_survey(after, out);
  write_frames(out / "refine_frames.csv", result);
  std::error_code code;
  if (fs::exists(in.survey / "tracks.csv", code)) fs::copy_file(in.survey / "tracks.csv", out / "tracks.csv");
  Json summary = summary_of(survey, result);
  summary.set("intrinsics", bundle.intrinsics == "auto" ? "none" : bundle.intrinsics);
  if (options.match) summary.set("matching", std::move(matching));
  rejects.insert(rejects.end(), result.rejects.begin(), result.rejects.end());
  return {std::move(summary), std::move(rejects)};
}

}  // namespace cairn::pipeline
