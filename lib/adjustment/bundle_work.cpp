#include "adjustment/bundle_work.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "adjustment/bundle_datum.hpp"
#include "adjustment/robust.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "camera/projection.hpp"
#include "geometry/alignment.hpp"

namespace cairn::adjustment {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;

camera::IntrinsicsSet intrinsics_set(const std::string& name) {
  return name == "focal"        ? camera::IntrinsicsSet::focal
         : name == "distortion" ? camera::IntrinsicsSet::distortion
         : name == "radial"     ? camera::IntrinsicsSet::radial
         : name == "all"        ? camera::IntrinsicsSet::all
                                : camera::IntrinsicsSet::none;
}

BundleLoss loss_of(const std::string& name) {
  return name == "none" ? BundleLoss::none : name == "cauchy" ? BundleLoss::cauchy : BundleLoss::huber;
}

std::int32_t frame_index(const BundleProblem& problem, survey::FrameId id, const std::string& record) {
  const auto it =
      std::lower_bound(problem.frames.begin(), problem.frames.end(), id,
                       [](const survey::Frame& frame, survey::FrameId wanted) { return frame.id < wanted; });
  if (it == problem.frames.end() || it->id != id)
    throw Error(ErrorCode::invalid_input, "observation of an unknown frame")
        .record(record)
        .found("frame " + std::to_string(id.value))
        .hint("Remove the observation, or add the frame with its pose");
  return static_cast<std::int32_t>(it - problem.frames.begin());
}

Track make_track(const BundleProblem& problem, const std::vector<survey::TieObservation>& observations,
                 const std::string& record, std::vector<base::Reject>& rejects) {
  Track track;
  for (const auto& seen : observations) {
    const auto frame = frame_index(problem, seen.frame, record);
    if (!seen.pixel.allFinite())
      throw Error(ErrorCode::invalid_input, "pixel is not finite")
          .record(record + ", frame " + std::to_string(seen.frame.value));
    const bool twice = std::any_of(track.observations.begin(), track.observations.end(),
                                   [&](const auto& other) { return other.frame == frame; });
    if (twice) {
      rejects.push_back({record + ", frame " + std::to_string(seen.frame.value), "duplicate_observation",
                         "the point is seen twice in one frame; the first observation is used"});
      continue;
    }
    track.observations.push_back({frame, seen.pixel, true, 0.0});
  }
  return track;
}

}  // namespace

BundleWork::BundleWork(const BundleProblem& p, const BundleOptions& o, std::vector<base::Reject>& rejects)
    : problem(p), options(o), cameras(p.cameras) {
  for (const auto& frame : problem.frames) {
    const std::string record = "frame " + std::to_string(frame.id.value);
    const auto it = std::find_if(cameras.begin(), cameras.end(), [&](const auto& c) { return c.id == frame.camera; });
    if (it == cameras.end())
      throw Error(ErrorCode::invalid_input, "frame of an unknown camera")
          .record(record)
          .found("camera " + std::to_string(frame.camera.value));
    if (!frame.T_world_camera.rotation.allFinite() || !frame.T_world_camera.translation.allFinite())
      throw Error(ErrorCode::invalid_input, "pose is not finite").record(record);
    if (!(frame.sigma_xy_m >= 0.0 && frame.sigma_z_m >= 0.0 && frame.sigma_rot_deg >= 0.0))
      throw Error(ErrorCode::invalid_input, "standard deviation of a pose is negative or not finite")
          .record(record)
          .allowed("0 or more; 0 = not known");
    camera_of.push_back(static_cast<std::int32_t>(it - cameras.begin()));
    poses.push_back(frame.T_world_camera);
    priors.push_back(prior_of(frame, options));
  }
  if (!problem.start.empty()) {
    if (problem.start.size() != poses.size())
      throw Error(ErrorCode::internal, "start poses are not one a frame").found(std::to_string(problem.start.size()));
    poses = problem.start;
  }
  held.assign(poses.size(), 0);
  never_used = held;
  reason.resize(poses.size());
  for (const auto& tie : problem.ties) {
    auto track = make_track(problem, tie.observations, "tie point " + std::to_string(tie.id.value), rejects);
    track.p_world = tie.p_world;
    track.placed = tie.p_world.allFinite();
    tracks.push_back(std::move(track));
  }
  for (std::size_t i = 0; i < problem.control.size(); ++i) {
    const auto& control = problem.control[i];
    const std::string record = "control point " + control.name;
    if (!control.p_world.allFinite() || !(control.sigma_xy_m > 0.0) || !(control.sigma_z_m > 0.0))
      throw Error(ErrorCode::invalid_input,
                  "position or standard deviation of a control point is not a positive number")
          .record(record);
    auto track = make_track(problem, control.observations, record, rejects);
    if (control.check_only) continue;
    track.control = static_cast<std::int32_t>(i);
    track.p_world = control.p_world;
    track.placed = true;
    tracks.push_back(std::move(track));
  }
}

std::size_t BundleWork::used_observations() const {
  std::size_t count = 0;
  for (const auto& track : tracks)
    if (track.used)
      count += static_cast<std::size_t>(
          std::count_if(track.observations.begin(), track.observations.end(), [](const auto& o) { return o.used; }));
  return count;
}

double BundleWork::median_error() const {
  std::vector<double> errors;
  for (const auto& track : tracks)
    if (track.used)
      for (const auto& seen : track.observations)
        if (seen.used) errors.push_back(seen.error_px);
  return errors.empty() ? 0.0 : median(std::move(errors));
}

void BundleWork::remember_start() {
  start_points.assign(tracks.size(), std::nullopt);
  if (!problem.start.empty()) return;  // the points belong to other poses than the frames'
  for (std::size_t i = 0; i < tracks.size(); ++i)
    if (tracks[i].placed) start_points[i] = tracks[i].p_world;
}

BundleSystem BundleWork::system(double widening) {
  BundleSystem system;
  system.intrinsics = intrinsics_set(options.intrinsics);
  system.loss = loss_of(options.loss);
  system.loss_scale = options.loss_scale * widening;
  system.prior_loss_scale = options.prior_loss_scale;
  system_index.assign(poses.size(), -1);
  camera_index_.assign(cameras.size(), -1);
  track_index_.assign(tracks.size(), -1);
  frames_in_.clear();
  cameras_in_.clear();
  for (std::size_t f = 0; f < poses.size(); ++f) {
    if (held[f] != 0) continue;
    auto& camera = camera_index_[static_cast<std::size_t>(camera_of[f])];
    if (camera < 0) {
      camera = static_cast<std::int32_t>(system.cameras.size());
      cameras_in_.push_back(static_cast<std::size_t>(camera_of[f]));
      system.cameras.push_back(cameras[cameras_in_.back()]);
    }
    system_index[f] = static_cast<std::int32_t>(system.poses.size());
    frames_in_.push_back(f);
    system.poses.push_back(poses[f]);
    system.camera_of.push_back(camera);
    system.priors.push_back(priors[f]);
    if (gauge == BundleGauge::aligned) {
      auto& prior = system.priors.back();
      prior.weight_rot = prior.weight_xy = prior.weight_z = 0.0;
    }
  }
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const auto& track = tracks[i];
    if (!track.used || (track.control >= 0 && gauge == BundleGauge::aligned)) continue;
    const auto point = static_cast<std::int32_t>(system.points.size());
    track_index_[i] = point;
    system.points.push_back(track.p_world);
    for (const auto& seen : track.observations)
      if (seen.used)
        system.observations.push_back({system_index[static_cast<std::size_t>(seen.frame)], point, seen.pixel,
                                       1.0 / (track.control >= 0 ? options.control_sigma_px : sigma_px),
                                       track.control >= 0});
    if (track.control < 0) continue;
    const auto& control = problem.control[static_cast<std::size_t>(track.control)];
    system.point_priors.push_back(
        {point, control.p_world, {1.0 / control.sigma_xy_m, 1.0 / control.sigma_xy_m, 1.0 / control.sigma_z_m}});
  }
  return system;
}

void BundleWork::take(const BundleSystem& solved) {
  for (std::size_t i = 0; i < frames_in_.size(); ++i) poses[frames_in_[i]] = solved.poses[i];
  for (std::size_t i = 0; i < cameras_in_.size(); ++i) cameras[cameras_in_[i]] = solved.cameras[i];
  for (std::size_t i = 0; i < tracks.size(); ++i)
    if (track_index_[i] >= 0) tracks[i].p_world = solved.points[static_cast<std::size_t>(track_index_[i])];
}

void BundleWork::apply(const geometry::Similarity& T) {
  for (std::size_t f = 0; f < poses.size(); ++f)
    if (held[f] == 0) poses[f] = geometry::transform_pose(T, poses[f]);
  for (auto& track : tracks)
    if (track.used) track.p_world = T * track.p_world;
}

double summed_error(const Views& views, const Track& track, const Vec3& p) {
  constexpr double kCut = 100.0;  // px
  double sum = 0.0;
  for (const auto& seen : track.observations) sum += std::min(kCut, reprojection_error(views, seen, p));
  return sum;
}

std::optional<Vec2> reprojection_residual(const Views& views, const TrackObservation& seen, const Vec3& p) {
  const auto f = static_cast<std::size_t>(seen.frame);
  const auto pixel =
      camera::project_world(views.cameras[static_cast<std::size_t>(views.camera_of[f])], views.poses[f], p);
  if (!pixel) return std::nullopt;
  return Vec2(*pixel - seen.pixel);
}

}  // namespace cairn::adjustment
