#include "localisation/history.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/angle.hpp"
#include "localisation/pool_pairs.hpp"
#include "localisation/triangulation.hpp"

namespace cairn::localisation {
namespace {

using geometry::Mat2;
using geometry::Mat3;
using geometry::Vec3;
using survey::TargetState;

constexpr double kSigmaShare = 0.25;  // of the size: a large object's outline has no sharper centre
constexpr double kFewFrames = 8.0;    // frames: up to here min_hit_ratio alone
constexpr double kManyFrames = 40.0;  // frames: from here min_hit_ratio_video alone

// Largest angle between the rays so far: each new one against the ends of the widest pair and the first.
class Parallax {
 public:
  void add(const Vec3& direction) {
    if (kept_.empty()) {
      kept_.push_back(direction);
      return;
    }
    double widest = 0.0;
    for (const auto& other : kept_)
      widest = std::max(widest, std::atan2(direction.cross(other).norm(), direction.dot(other)));
    if (widest > angle_) angle_ = widest;
    // New corners of the fan are kept; what lies inside it is not needed.
    constexpr double kNew = 0.5;  // of the widest angle
    constexpr std::size_t kMost = 24;
    if (kept_.size() < kMost && widest > kNew * angle_) kept_.push_back(direction);
  }
  [[nodiscard]] double angle() const { return angle_; }

 private:
  std::vector<Vec3> kept_;
  double angle_ = 0.0;
};

std::optional<std::size_t> frame_entered(const PreparedBoxes& prepared, const LiveTarget& live, TargetState state) {
  for (const auto& entry : live.history)
    if (entry.state == state)
      for (const std::size_t f : live.keyframes)
        if (prepared.frames[f].id == entry.frame) return f;
  return std::nullopt;
}

}  // namespace

double least_hit_ratio(const LocateOptions& options, std::size_t visible_frames) {
  const double n = static_cast<double>(visible_frames);
  const double share = std::clamp((n - kFewFrames) / (kManyFrames - kFewFrames), 0.0, 1.0);
  return options.min_hit_ratio +
         share * (std::max(options.min_hit_ratio, options.min_hit_ratio_video) - options.min_hit_ratio);
}

double largest_sigma(const LocateOptions& options, double size_m) {
  return std::max(options.max_sigma_m, kSigmaShare * size_m);
}

Stages stages_of(const PreparedBoxes& prepared, const Candidate& c, const LiveTarget& live,
                 const LocateOptions& options) {
  Stages stages;
  std::vector<std::size_t> boxes = c.boxes;
  std::sort(boxes.begin(), boxes.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(prepared.boxes[a].frame, a) < std::pair(prepared.boxes[b].frame, b);
  });
  const std::vector<std::size_t> visible = frames_showing(prepared, c, options);
  const auto gathered = frame_entered(prepared, live, TargetState::converging);
  const double allowed = largest_sigma(options, c.size_m);
  const auto enter = [&](TargetState state, std::size_t frame) {
    for (const auto& entry : stages.history)
      if (entry.state == state) return;
    stages.history.push_back({state, prepared.frames[frame].id});
  };

  Mat3 information = Mat3::Zero();
  Parallax parallax;
  std::size_t shown = 0, hits = 0;
  // The residuals' scale is in the final covariance, not in the sum below.
  double scale = 1.0;
  const auto sum_of = [&](std::size_t box) -> std::optional<Mat3> {
    const Box& b = prepared.boxes[box];
    const FrameView& frame = prepared.frames[b.frame];
    const auto at = appearance(frame, c.fix.centre, Mat3::Zero());
    if (!at) return std::nullopt;
    Mat2 covariance = at->covariance;
    covariance.diagonal() += b.sigma_px.cwiseAbs2();
    const auto jacobian = frame.view.jacobian(frame.view.to_camera(c.fix.centre));
    return Mat3(jacobian.transpose() * covariance.inverse() * jacobian);
  };
  Mat3 all = Mat3::Zero();
  for (const std::size_t b : boxes) all += sum_of(b).value_or(Mat3::Zero());
  if (const double trace = all.inverse().trace(); std::isfinite(trace) && trace > 0.0)
    scale = c.fix.covariance.trace() / trace;

  bool enough = false, wide = false, sure = false, frequent = false;
  for (const std::size_t b : boxes) {
    const std::size_t frame = prepared.boxes[b].frame;
    ++hits;
    while (shown < visible.size() && visible[shown] <= frame) ++shown;
    information += sum_of(b).value_or(Mat3::Zero());
    parallax.add((c.fix.centre - prepared.frames[frame].view.T_world_camera.translation).normalized());
    const Mat3 covariance = scale * information.inverse();
    enough = hits >= static_cast<std::size_t>(options.min_boxes);
    wide = base::rad_to_deg(parallax.angle()) >= options.min_parallax_deg;
    sure = covariance.allFinite() && covariance.diagonal().maxCoeff() <= allowed * allowed;
    frequent = static_cast<double>(hits) >= least_hit_ratio(options, shown) * static_cast<double>(shown);
    if (hits < static_cast<std::size_t>(options.generation_boxes) || !frequent) continue;
    enter(TargetState::generated, frame);
    const bool converged = enough && wide && sure;
    if (converged || (gathered && *gathered <= frame)) enter(TargetState::converging, frame);
    if (converged) enter(TargetState::converged, frame);
  }
  stages.rare =
      static_cast<double>(hits) < least_hit_ratio(options, visible.size()) * static_cast<double>(visible.size());
  if (!enough) stages.missing.emplace_back("too_few_boxes");
  if (base::rad_to_deg(c.fix.parallax_rad) < options.min_parallax_deg) stages.missing.emplace_back("one_direction");
  if (c.fix.covariance.diagonal().maxCoeff() > allowed * allowed) stages.missing.emplace_back("uncertain_centre");
  if (stages.rare) stages.missing.emplace_back("rarely_seen");
  if (stages.rare || stages.history.empty()) {
    // Converged is a verdict over the whole recording: what does not hold in the end never did.
    std::erase_if(stages.history, [](const auto& entry) { return entry.state == TargetState::converged; });
    const std::size_t last = std::max(prepared.boxes[boxes.back()].frame, visible.empty() ? 0 : visible.back());
    enter(TargetState::deregistered, last);
  } else if (stages.missing.empty()) {
    // What holds in the end, held when the last box came at the latest.
    for (const auto state : {TargetState::converging, TargetState::converged})
      enter(state, prepared.boxes[boxes.back()].frame);
  } else {
    std::erase_if(stages.history, [](const auto& entry) { return entry.state == TargetState::converged; });
  }
  return stages;
}

}  // namespace cairn::localisation
