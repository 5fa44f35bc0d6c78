#include "localisation/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"
#include "geometry/assignment.hpp"
#include "localisation/association.hpp"
#include "localisation/bounding_cylinder.hpp"
#include "localisation/triangulation.hpp"

namespace cairn::localisation {
namespace {

using geometry::PixelBox;
using geometry::Vec3;
using survey::TargetState;

constexpr double kTrackGate =
    2.0;  // times the gate: a box of the same track that is farther off belongs to another thing
constexpr double kEnlargementShare = 0.02;  // robust: at least this share of the box on each side (papers.md, 2.11)

double yaw_of(const geometry::RigidTransform& pose) {
  // Heading of the camera's x axis: defined for every view but one along the horizon's axis itself.
  return std::atan2(pose.rotation(1, 0), pose.rotation(0, 0));
}

PixelBox enlarged(const PixelBox& box, double by_x, double by_y) {
  return {box.xmin - by_x, box.ymin - by_y, box.xmax + by_x, box.ymax + by_y};
}

double size_of(const Box& box, const View& view, const Vec3& at) {
  return box.diagonal_px() * std::max(0.0, view.to_camera(at).z()) / view.fx_px;
}

void note(LiveTarget& target, const std::string& reason) {
  if (std::find(target.reasons.begin(), target.reasons.end(), reason) == target.reasons.end())
    target.reasons.push_back(reason);
}

}  // namespace

double reach_of(const Gaussian& gaussian) {
  return 4.0 * std::sqrt(std::max(0.0, gaussian.covariance.trace()));
}

bool is_keyframe(const geometry::RigidTransform& pose, const geometry::RigidTransform& last, Mode mode,
                 double distance_m, double angle_deg) {
  if ((pose.translation - last.translation).norm() > distance_m) return true;
  double angle = 0.0;
  if (mode == Mode::paper) {
    angle = std::abs(std::remainder(yaw_of(pose) - yaw_of(last), 2.0 * std::numbers::pi));
  } else {
    angle = geometry::rotation_angle(last.rotation.transpose() * pose.rotation);
  }
  return angle > base::deg_to_rad(angle_deg);
}

PointsTracker::PointsTracker(const PreparedBoxes& prepared, const DepthPrior& depth, const LocateOptions& options,
                             const base::RunContext& ctx)
    : prepared_(prepared), depth_(depth), options_(options), ctx_(ctx), mode_(mode_of(options)) {
  const double sum = options.gaussian_weight + options.uniform_weight;
  update_options_.noise_m = options.noise_m;
  update_options_.gaussian_weight = options.gaussian_weight / sum;
  update_options_.uniform_weight = options.uniform_weight / sum;
  update_options_.move_points = update_options_.cheirality = update_options_.systematic = mode_ == Mode::robust;
}

LiveTarget PointsTracker::generate(survey::TargetId id, std::size_t box_index) const {
  const Box& box = prepared_.boxes[box_index];
  const FrameView& frame = prepared_.frames[box.frame];
  const DepthRange range = depth_.range(box);
  double by_x = options_.enlargement_px, by_y = options_.enlargement_px;
  if (mode_ == Mode::robust && options_.enlargement_px == 0.0) {
    // What the pose's error does to a pixel at mid depth, two sigmas, and the box's own error.
    const double depth = 0.5 * (range.near_m + range.far_m);
    const double pose_px = frame.view.fx_px * std::hypot(frame.sigma_xy_m / depth, frame.sigma_rot_rad);
    by_x = std::max(kEnlargementShare * box.ideal.width(), 2.0 * std::hypot(pose_px, box.sigma_px.x()));
    by_y = std::max(kEnlargementShare * box.ideal.height(), 2.0 * std::hypot(pose_px, box.sigma_px.y()));
  }
  LiveTarget target{.id = id,
                    .object_class = box.object_class,
                    .random = ctx_.random("locate", static_cast<std::uint64_t>(id.value))};
  target.points =
      generate_points(frame.view, enlarged(box.ideal, by_x, by_y), static_cast<std::size_t>(options_.points_per_target),
                      range, mode_ == Mode::paper ? BoxFill::corner_weights : BoxFill::uniform, target.random);
  target.gaussian = fit_gaussian(target.points);
  target.boxes.push_back(box_index);
  target.keyframes.push_back(box.frame);
  target.size_m = size_of(box, frame.view, target.gaussian.mean);
  if (const auto h = differential_entropy(target.gaussian.covariance)) target.entropy_nats.push_back(*h);
  enter(target, TargetState::generated, box.frame);
  return target;
}

void PointsTracker::enter(LiveTarget& target, TargetState state, std::size_t frame) const {
  target.state = state;
  target.history.push_back({state, prepared_.frames[frame].id});
}

void PointsTracker::give_up(LiveTarget& target, const std::string& reason, std::size_t frame) const {
  enter(target, TargetState::deregistered, frame);
  note(target, reason);
  target.cylinder = bounding_cylinder(target.points);
  target.points = Points(0, 3);  // hundreds of false boxes must not hold 2000 points each
}

void PointsTracker::update(LiveTarget& target, std::size_t box_index) const {
  const Box& box = prepared_.boxes[box_index];
  const FrameView& frame = prepared_.frames[box.frame];
  const double weight = static_cast<double>(target.boxes.size());
  target.boxes.push_back(box_index);
  target.misses = 0;
  const auto& last = prepared_.frames[target.keyframes.back()].view.T_world_camera;
  if (!is_keyframe(frame.view.T_world_camera, last, mode_, options_.keyframe_distance_m, options_.keyframe_angle_deg))
    return;
  const Gaussian before = target.gaussian;
  const auto report = update_points(target.points, frame.view, box.ideal, update_options_, target.random);
  if (!report.updated) {
    note(target, "all_weights_zero");
    return;
  }
  if (report.behind > 0) note(target, "points_behind_camera");
  target.gaussian = fit_gaussian(target.points);
  target.keyframes.push_back(box.frame);
  target.size_m = (target.size_m * weight + size_of(box, frame.view, target.gaussian.mean)) / (weight + 1.0);
  const auto entropy = differential_entropy(target.gaussian.covariance);
  const auto change = divergence(target.gaussian, before);
  if (!entropy || !change) {
    note(target, "singular_covariance");
    target.settled = 0;
    return;
  }
  target.entropy_nats.push_back(*entropy);
  target.divergence.push_back(*change);
  target.settled = *change < options_.divergence_converged ? target.settled + 1 : 0;
  if (target.state == TargetState::generated && *entropy < options_.entropy_converging_nats)
    enter(target, TargetState::converging, box.frame);
  if (target.state == TargetState::converging && target.settled >= options_.divergence_updates)
    enter(target, TargetState::converged, box.frame);
}

std::vector<double> PointsTracker::scores(const LiveTarget& target, const FrameView& frame) const {
  std::vector<std::size_t> candidates;
  std::vector<PixelBox> boxes;
  std::vector<double> score(frame.boxes.size(), 0.0);
  const auto add = [&](std::size_t b) {
    candidates.push_back(b);
    boxes.push_back(prepared_.boxes[frame.boxes[b]].ideal);
  };
  const survey::TrackId track = prepared_.boxes[target.boxes.back()].track;
  std::size_t own = frame.boxes.size();
  if (mode_ == Mode::paper) {
    for (std::size_t b = 0; b < frame.boxes.size(); ++b)
      if (prepared_.boxes[frame.boxes[b]].object_class == target.object_class) add(b);
  } else {
    const auto at = appearance(frame, target.gaussian.mean, target.gaussian.covariance);
    if (!at) return score;
    const double gate2 = options_.mahalanobis_gate * options_.mahalanobis_gate;
    for (std::size_t b = 0; b < frame.boxes.size(); ++b) {
      const Box& box = prepared_.boxes[frame.boxes[b]];
      if (box.object_class != target.object_class) continue;
      const bool same = track.valid() && box.track == track;
      const double d2 = squared_distance(*at, box.centre_px, box.sigma_px);
      if (d2 > (same ? kTrackGate * kTrackGate : 1.0) * gate2) continue;
      const double size = box.diagonal_px() * at->depth_m / frame.view.fx_px;
      if (size > target.size_m * options_.size_ratio || size * options_.size_ratio < target.size_m) continue;
      if (same) own = b;
      add(b);
    }
  }
  if (candidates.empty()) return score;
  const auto counts = count_inside(target.points, frame.view, boxes, mode_ == Mode::robust);
  for (std::size_t c = 0; c < candidates.size(); ++c) score[candidates[c]] = static_cast<double>(counts[c]);
  if (own < score.size()) score[own] += static_cast<double>(options_.points_per_target);
  return score;
}

bool PointsTracker::should_be_visible(const LiveTarget& target, const FrameView& frame) const {
  const auto pixel = frame.view.project(target.gaussian.mean);
  if (!pixel) return false;
  const double depth = frame.view.to_camera(target.gaussian.mean).z();
  const double half = 0.5 * target.size_m * frame.view.fx_px / depth + options_.edge_margin_px;
  return pixel->x() >= half && pixel->y() >= half && pixel->x() <= static_cast<double>(frame.camera->width_px) - half &&
         pixel->y() <= static_cast<double>(frame.camera->height_px) - half;
}

// A19, with "mapped" read as "converged earlier": offline nothing is mapped in between.
void PointsTracker::check_duplicate(LiveTarget& target, std::size_t frame) {
  for (const std::size_t t : active_) {
    const LiveTarget& other = targets_[t];
    if (other.id == target.id || other.state != TargetState::converged || other.object_class != target.object_class)
      continue;
    if ((other.gaussian.mean - target.gaussian.mean).norm() >= options_.target_spacing_m) continue;
    give_up(target, "duplicate_of_" + std::to_string(other.id.value), frame);
    return;
  }
}

void PointsTracker::step(std::size_t frame_index) {
  const FrameView& frame = prepared_.frames[frame_index];
  const std::size_t count = frame.boxes.size();
  std::erase_if(active_, [this](std::size_t t) { return targets_[t].state == TargetState::deregistered; });

  // Scores (A11), and the targets that have any: the others need no assignment.
  std::vector<std::vector<double>> scores_of(active_.size());
  if (count > 0) {
    constexpr std::size_t kGrain = 8;  // targets: about 20 us of work each
    base::parallel_for(active_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) scores_of[a] = scores(targets_[active_[a]], frame);
    });
  }
  std::vector<std::size_t> rows;
  std::vector<double> score;
  for (std::size_t a = 0; a < active_.size(); ++a) {
    if (std::none_of(scores_of[a].begin(), scores_of[a].end(), [](double s) { return s > 0.0; })) continue;
    rows.push_back(a);
    score.insert(score.end(), scores_of[a].begin(), scores_of[a].end());
  }
  const double least = options_.min_points_fraction * static_cast<double>(options_.points_per_target);
  const auto pairs = associate(score, rows.size(), count, least);
  std::vector<std::size_t> box_of(active_.size(), geometry::kUnassigned);
  for (std::size_t r = 0; r < rows.size(); ++r) box_of[rows[r]] = pairs[r];

  std::vector<bool> taken(count, false), was_converged(active_.size(), false);
  for (std::size_t a = 0; a < active_.size(); ++a) {
    was_converged[a] = targets_[active_[a]].state == TargetState::converged;
    if (box_of[a] != geometry::kUnassigned) taken[box_of[a]] = true;
  }
  base::parallel_for(rows.size(), 2, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r)
      if (pairs[r] != geometry::kUnassigned) update(targets_[active_[rows[r]]], frame.boxes[pairs[r]]);
  });
  for (std::size_t a = 0; a < active_.size(); ++a) {
    LiveTarget& target = targets_[active_[a]];
    if (box_of[a] != geometry::kUnassigned) {
      if (mode_ == Mode::paper && !was_converged[a] && target.state == TargetState::converged)
        check_duplicate(target, frame_index);
      continue;
    }
    if (was_converged[a]) continue;
    if (mode_ == Mode::robust && !should_be_visible(target, frame)) continue;
    if (++target.misses >= options_.missing_iterations) give_up(target, "missed", frame_index);
  }
  for (std::size_t b = 0; b < count; ++b) {
    if (taken[b]) continue;
    active_.push_back(targets_.size());
    targets_.push_back(generate(survey::TargetId(static_cast<std::int64_t>(targets_.size()) + 1), frame.boxes[b]));
  }
}

}  // namespace cairn::localisation
