// What became of frames, control points and tie points of an adjustment.
#include <cmath>

#include "adjustment/bundle_datum.hpp"
#include "adjustment/bundle_work.hpp"
#include "base/angle.hpp"
#include "base/number_text.hpp"

namespace cairn::adjustment {
namespace {

using base::to_fixed;
using geometry::Vec3;

std::string frame_record(survey::FrameId id) {
  return "frame " + std::to_string(id.value);
}

std::string meaning_of(const std::string& reason) {
  if (reason == "too_few_observations") return "too few tie points are seen in it; it keeps its pose";
  if (reason == "not_connected") return "no tie points join it to the largest group of frames; it keeps its pose";
  return "its group of frames has neither priors nor control points; it keeps its pose";
}

struct Squares {
  double sum = 0.0;
  std::size_t count = 0;
  void add(double squared) {
    sum += squared;
    ++count;
  }
  [[nodiscard]] double rms() const { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0; }
};

// Distance of a pose from its prior in sigmas, of what the prior knows.
double prior_distance(const BundlePrior& prior, const geometry::RigidTransform& pose) {
  const Vec3 shift = pose.translation - prior.pose.translation;
  const Vec3 turn = log_rotation(prior.pose.rotation.transpose() * pose.rotation);
  return std::sqrt(shift.cwiseProduct(Vec3(prior.weight_xy, prior.weight_xy, prior.weight_z)).squaredNorm() +
                   (prior.weight_rot * turn).squaredNorm());
}

std::vector<geometry::RigidTransform> start_poses(const BundleProblem& problem) {
  std::vector<geometry::RigidTransform> poses;
  for (const auto& frame : problem.frames) poses.push_back(frame.T_world_camera);
  return poses;
}

std::string_view point_meaning(std::string_view reason) {
  if (reason == "seen_once") return "seen in one frame only";
  if (reason == "no_parallax") return "its rays are nearly parallel";
  if (reason == "not_triangulated") return "its rays do not meet in front of the cameras";
  return "fewer than two of its observations can be used";
}

}  // namespace

void report_frames(const BundleWork& work, BundleResult& result) {
  const auto& frames = work.problem.frames;
  const auto starts = start_poses(work.problem);
  const Views before{work.problem.cameras, starts, work.camera_of}, after = work.views();
  std::vector<Squares> squares_before(frames.size()), squares_after(frames.size());
  Squares all_before, all_after;
  result.frame_reports.resize(frames.size());
  for (std::size_t i = 0; i < work.tracks.size(); ++i) {
    const auto& track = work.tracks[i];
    if (track.control >= 0) continue;
    auto start = work.start_points[i];
    if (!start) start = triangulate_track(before, track, 1e300, work.held);
    for (const auto& seen : track.observations) {
      const auto f = static_cast<std::size_t>(seen.frame);
      auto& report = result.frame_reports[f];
      if (!track.used || !seen.used) {
        report.outliers += work.held[f] == 0 && std::isfinite(seen.error_px) && track.used ? 1U : 0U;
        continue;
      }
      ++report.observations;
      if (start)
        if (const auto r = reprojection_residual(before, seen, *start)) {
          squares_before[f].add(r->squaredNorm());
          all_before.add(r->squaredNorm());
        }
      if (const auto r = reprojection_residual(after, seen, track.p_world)) {
        squares_after[f].add(r->squaredNorm());
        all_after.add(r->squaredNorm());
      }
    }
  }
  for (std::size_t f = 0; f < frames.size(); ++f) {
    auto& report = result.frame_reports[f];
    report.frame = frames[f].id;
    report.reason = work.reason[f];
    report.rms_before_px = squares_before[f].rms();
    report.rms_after_px = squares_after[f].rms();
    report.moved_m = (work.poses[f].translation - starts[f].translation).norm();
    report.turned_deg =
        base::rad_to_deg(geometry::rotation_angle(starts[f].rotation.transpose() * work.poses[f].rotation));
    if (work.gauge != BundleGauge::aligned) {
      report.prior_sigmas = prior_distance(work.priors[f], work.poses[f]);
      report.prior_doubted = work.options.prior_loss_scale > 0.0 && report.prior_sigmas > work.options.prior_loss_scale;
    }
    auto frame = frames[f];
    if (report.reason.empty()) {
      frame.T_world_camera = work.poses[f];
      ++result.frames_adjusted;
    } else {
      result.rejects.push_back({frame_record(frame.id), report.reason, meaning_of(report.reason)});
    }
    result.frames.push_back(std::move(frame));
  }
  result.cameras = work.cameras;
  result.gauge = work.gauge;
  result.sigma_px = work.sigma_px;
  result.rms_before_px = all_before.rms();
  result.rms_after_px = all_after.rms();
}

void report_control(const BundleWork& work, BundleResult& result) {
  const auto starts = start_poses(work.problem);
  const Views before{work.problem.cameras, starts, work.camera_of}, after = work.views();
  std::size_t next = 0;  // the control tracks stand after the ties, in order
  while (next < work.tracks.size() && work.tracks[next].control < 0) ++next;
  for (const auto& control : work.problem.control) {
    BundleControl report;
    report.name = control.name;
    report.check_only = control.check_only;
    Track track;
    if (control.check_only) {
      for (const auto& seen : control.observations)
        for (std::size_t f = 0; f < work.problem.frames.size(); ++f)
          if (work.problem.frames[f].id == seen.frame)
            track.observations.push_back({static_cast<std::int32_t>(f), seen.pixel, work.held[f] == 0, 0.0});
    } else {
      track = work.tracks[next++];
    }
    std::optional<Vec3> place = track.p_world;
    const auto place_before = triangulate_track(before, track, 1e300, work.held);
    if (control.check_only || work.gauge == BundleGauge::aligned)
      place = triangulate_track(after, track, 1e300, work.held);
    for (auto& seen : track.observations) report.observations += seen.used ? 1U : 0U;
    if (control.check_only ? !place : !track.used) report.reason = report.observations == 1 ? "seen_once" : "not_seen";
    else if (!control.check_only && work.gauge == BundleGauge::aligned) report.reason = "too_few_for_a_datum";
    if (place_before) report.before = *place_before - control.p_world;
    if (place && (report.reason.empty() || report.reason == "too_few_for_a_datum")) {
      report.after = *place - control.p_world;
      Squares squares;
      for (const auto& seen : track.observations)
        if (const auto r = seen.used ? reprojection_residual(after, seen, *place) : std::nullopt)
          squares.add(r->squaredNorm());
      report.rms_px = squares.rms();
    }
    if (!report.reason.empty())
      result.rejects.push_back({(control.check_only ? "check point " : "control point ") + control.name, report.reason,
                                report.reason == "too_few_for_a_datum"
                                    ? "fewer than three control points outside one line: measured, not used"
                                    : "not seen in enough adjusted frames"});
    result.control.push_back(std::move(report));
  }
}

void report_points(const BundleWork& work, BundleResult& result) {
  for (std::size_t i = 0; i < work.problem.ties.size(); ++i) {
    const auto& tie = work.problem.ties[i];
    const auto& track = work.tracks[i];
    const std::string record = "tie point " + std::to_string(tie.id.value);
    if (!track.used) {
      result.rejects.push_back({record, std::string(track.reason), std::string(point_meaning(track.reason))});
      continue;
    }
    survey::TiePoint used{tie.id, track.p_world, {}};
    for (const auto& seen : track.observations) {
      const auto f = static_cast<std::size_t>(seen.frame);
      const auto id = work.problem.frames[f].id;
      if (seen.used) {
        used.observations.push_back({id, seen.pixel});
      } else if (work.held[f] == 0) {
        result.rejects.push_back({record + ", " + frame_record(id), "outlier",
                                  std::isfinite(seen.error_px) ? to_fixed(seen.error_px, 2) + " px off its point"
                                                               : std::string("the point lies behind the camera")});
      }
    }
    result.observations += used.observations.size();
    result.ties.push_back(std::move(used));
  }
  result.points = result.ties.size();
}

}  // namespace cairn::adjustment
