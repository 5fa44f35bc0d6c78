#include "pipeline/locate_stage.hpp"

#include <cmath>
#include <optional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "io/csv.hpp"
#include "io/ply.hpp"
#include "io/survey_folder.hpp"
#include "io/targets_json.hpp"
#include "io/tracks_csv.hpp"
#include "pipeline/function_stage.hpp"
#include "pipeline/target_plots.hpp"
#include "pipeline/terrain_height.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using localisation::LocateResult;

// An object seen along a ray stands on the ground where the ray meets it, or nearer by up to its height.
localisation::DepthBound terrain_bound(const TerrainHeight& terrain, double object_height_m) {
  return [&terrain, object_height_m](const localisation::View& view,
                                     const geometry::Vec3& direction) -> std::optional<localisation::DepthRange> {
    constexpr double kBelow = 1.0;  // m of drop; the terrain's own error
    const auto depth = terrain.depth(view.T_world_camera.translation, direction);
    if (!depth) return std::nullopt;
    const double per_metre = 1.0 / -direction.z();
    const double near_m = *depth - object_height_m * per_metre, far_m = *depth + kBelow * per_metre;
    return localisation::DepthRange{std::max(0.1, near_m), far_m};
  };
}

void write_evidence(const fs::path& path, const LocateResult& result) {
  io::CsvWriter csv(path, {"target_id",
                           "class",
                           "state",
                           "boxes",
                           "visible_frames",
                           "rms_px",
                           "parallax_deg",
                           "size_m",
                           "east_m",
                           "north_m",
                           "up_m",
                           "sigma_east_m",
                           "sigma_north_m",
                           "sigma_up_m",
                           "points_east_m",
                           "points_north_m",
                           "points_up_m",
                           "points_sigma_east_m",
                           "points_sigma_north_m",
                           "points_sigma_up_m",
                           "entropy_nats",
                           "divergence",
                           "refined_east_m",
                           "refined_north_m",
                           "refined_up_m",
                           "refined_sigma_east_m",
                           "refined_sigma_north_m",
                           "refined_sigma_up_m",
                           "refined_radius_m",
                           "refined_height_m",
                           "refined_rms_px",
                           "refined_boxes",
                           "refined_rejected_boxes",
                           "reasons"});
  for (std::size_t i = 0; i < result.targets.size(); ++i) {
    const auto& t = result.targets[i];
    const auto& e = result.evidence[i];
    csv.cell(t.id.value)
        .cell(t.object_class)
        .cell(survey::name_of(t.state))
        .cell(static_cast<std::int64_t>(e.boxes))
        .cell(static_cast<std::int64_t>(e.visible_frames))
        .cell(e.rms_px)
        .cell(e.parallax_deg)
        .cell(e.size_m);
    for (int a = 0; a < 3; ++a) csv.cell(t.centre[a]);
    for (int a = 0; a < 3; ++a) csv.cell(std::sqrt(t.covariance(a, a)));
    for (int a = 0; a < 3; ++a) csv.cell(e.points_mean[a]);
    for (int a = 0; a < 3; ++a) csv.cell(std::sqrt(e.points_covariance(a, a)));
    const double unknown = std::nan("");  // an empty cell
    csv.cell(t.entropy_nats.empty() ? unknown : t.entropy_nats.back());
    csv.cell(t.divergence.empty() ? unknown : t.divergence.back());
    if (t.refined) {
      const auto& r = *t.refined;
      for (int a = 0; a < 3; ++a) csv.cell(r.centre[a]);
      for (int a = 0; a < 3; ++a) csv.cell(std::sqrt(r.covariance(a, a)));
      csv.cell(r.cylinder.radius).cell(r.cylinder.height()).cell(r.rms_px);
      csv.cell(static_cast<std::int64_t>(r.boxes)).cell(static_cast<std::int64_t>(r.rejected_boxes));
    } else {
      constexpr int kRefinedCells = 11;
      for (int cell = 0; cell < kRefinedCells; ++cell) csv.cell("");
    }
    std::string reasons;
    for (const auto& reason : t.reasons) reasons += (reasons.empty() ? "" : ";") + reason;
    csv.cell(reasons);
    csv.end_row();
  }
  csv.finish();
}

void write_points(const fs::path& folder, const LocateResult& result) {
  fs::create_directories(folder);
  for (std::size_t i = 0; i < result.targets.size(); ++i) {
    const auto& points = result.points[i];
    if (points.rows() == 0) continue;
    geometry::PointCloud cloud;
    for (Eigen::Index row = 0; row < points.rows(); ++row) cloud.positions.emplace_back(points.row(row).transpose());
    io::write_ply(folder / (std::to_string(result.targets[i].id.value) + ".ply"), cloud,
                  {.crs = "", .comments = {"local ENU, m"}});
  }
}

io::Json refined_summary(const localisation::BodyFitCounts& b) {
  return io::Json::object({{"fitted", b.fitted},
                           {"failed", b.failed},
                           {"boxes", b.boxes},
                           {"rejected_boxes", b.rejected_boxes},
                           {"box_noise_scale", b.box_noise_scale},
                           {"pose_noise_scale", b.pose_noise_scale}});
}

void write_plots(const fs::path& folder, const LocateResult& result, const localisation::LocateOptions& options) {
  fs::create_directories(folder);
  for (const auto& target : result.targets)
    if (target.state != survey::TargetState::deregistered)
      base::write_file(folder / (std::to_string(target.id.value) + ".svg"),
                       history_plot(target, {options.entropy_converging_nats, options.divergence_converged}));
}

void write_drift(const fs::path& path, const LocateResult& result) {
  io::CsvWriter csv(path, {"frame_id", "east_m", "north_m", "up_m"});
  for (const auto& [frame, offset] : result.drift) {
    csv.cell(frame.value);
    for (int a = 0; a < 3; ++a) csv.cell(offset[a]);
    csv.end_row();
  }
  csv.finish();
}

io::Json summary_of(const LocateResult& result, const std::optional<localisation::BodyFitCounts>& bodies) {
  const auto& c = result.counts;
  return io::Json::object({{"detections", c.detections},
                           {"used", c.used},
                           {"rejected", c.rejected},
                           {"frames", c.frames},
                           {"targets", result.targets.size()},
                           {"generated", c.generated},
                           {"converging", c.converging},
                           {"converged", c.converged},
                           {"deregistered", c.deregistered},
                           {"merged", c.merged},
                           {"recovered", c.recovered},
                           {"moved_boxes", c.moved_boxes},
                           {"coasted", c.coasted},
                           {"clock_jumps", c.clock_jumps},
                           {"drift_m", c.drift_m},
                           {"noise_scale", c.noise_scale},
                           {"depth_source", c.depth_source},
                           {"refined", bodies ? refined_summary(*bodies) : io::Json()},
                           {"rejects_by_reason", count_by_reason(result.rejects)}});
}

}  // namespace

Outcome locate_stage(const LocateInputs& in, const fs::path& out, const LocateStageOptions& options,
                     base::RunContext& ctx) {
  const survey::Survey survey = io::read_survey(in.survey);
  if (survey.detections.empty())
    throw base::Error(base::ErrorCode::failed_precondition, "the survey has no detections")
        .file((in.survey / "detections.csv").string())
        .hint("Attach a detector's boxes with 'cairn import ... --detections FILE'");
  std::optional<TerrainHeight> terrain;
  localisation::DepthBound bound;
  if (!in.terrain.empty()) {
    terrain.emplace(in.terrain, geodesy::LocalFrame(survey.manifest.origin.position));
    bound = terrain_bound(*terrain, options.locate.height_above_ground_m);
  }
  std::vector<survey::TrackedBox> tracked;
  if (!in.tracks.empty()) tracked = io::read_tracks(in.tracks, survey);
  const localisation::Tracks tracks = in.tracks.empty() ? localisation::Tracks() : localisation::Tracks(tracked);
  LocateResult result = localisation::locate(survey, tracks, options.locate, ctx, bound);
  std::optional<localisation::BodyFitCounts> bodies;
  if (options.refine_bodies) bodies = localisation::refine_bodies(result, survey, options.body, ctx);
  io::write_targets(out / "targets.json", {survey.manifest.origin, result.targets});
  write_evidence(out / "target_evidence.csv", result);
  if (options.points) write_points(out / "points", result);
  if (options.plots) write_plots(out / "plots", result, options.locate);
  if (!result.drift.empty()) write_drift(out / "drift.csv", result);
  return {summary_of(result, bodies), result.rejects};
}

std::unique_ptr<Stage> make_locate_stage() {
  return make_function_stage<LocateStageOptions>(
      {"locate",
       {},
       {},
       [](const StageInputs& in, const LocateStageOptions& options) -> Estimate {
         // Every box may become a target: its points, kept once by the tracker and once for the result.
         const auto survey = io::read_survey(in.survey);
         const auto points = static_cast<std::uint64_t>(localisation::resolved(options.locate).points_per_target);
         const std::uint64_t bytes = survey.detections.size() * points * 3 * sizeof(double);
         return {2 * bytes + survey.ties.size() * 256 + (std::uint64_t{16} << 20U),
                 survey.detections.size() * 2048 + (options.points ? bytes : 0)};
       },
       [](const StageInputs& in, const fs::path& out, const LocateStageOptions& options, base::RunContext& ctx) {
         return locate_stage({in.survey, {}, {}}, out, options, ctx);
       },
       [](const StageInputs& in) -> std::string {
         return io::read_survey(in.survey).detections.empty() ? "detections" : "";
       }});
}

}  // namespace cairn::pipeline
