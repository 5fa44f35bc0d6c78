// The points tracker: targets from boxes, one frame after the other (paper A, 2.4 to 2.8 and 2.12).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "localisation/boxes.hpp"
#include "localisation/depth_prior.hpp"
#include "localisation/options.hpp"
#include "localisation/points.hpp"
#include "survey/target.hpp"

namespace cairn::localisation {

// A target while it is followed.
struct LiveTarget {
  survey::TargetId id;
  std::size_t object_class = 0;
  survey::TargetState state = survey::TargetState::generated;
  std::vector<std::size_t> boxes{};      // indices into PreparedBoxes::boxes, in order of association
  std::vector<std::size_t> keyframes{};  // indices into PreparedBoxes::frames
  Points points{};                       // none once it is deregistered: `cylinder` was taken before
  Gaussian gaussian{};
  double size_m = 0.0;  // box diagonal x depth / focal length, mean over the boxes
  std::vector<double> entropy_nats{}, divergence{};
  std::vector<std::string> reasons{};
  std::int64_t misses = 0;   // in a row
  std::int64_t settled = 0;  // updates in a row with a small divergence
  std::vector<survey::StageEntry> history{};
  std::optional<geometry::VerticalCylinder> cylinder{};  // of the last points, where they were given up

  base::Random random;
};

// Whether a pose is far enough from the last keyframe's to update the points (A13).
// angle: of the yaw in paper (D13), of the whole rotation in robust.
[[nodiscard]] bool is_keyframe(const geometry::RigidTransform& pose, const geometry::RigidTransform& last, Mode mode,
                               double distance_m, double angle_deg);

class PointsTracker {
 public:
  // The references must outlive the tracker. Options are resolved ones.
  PointsTracker(const PreparedBoxes& prepared, const DepthPrior& depth, const LocateOptions& options,
                const base::RunContext& ctx);

  // One iteration, for the frame of that index; frames come in order.
  void step(std::size_t frame);

  // A target made of one box (A10), and its update with another (A15 to A17). Used by step; also to run the
  // filter again over a target's boxes once these are certain.
  [[nodiscard]] LiveTarget generate(survey::TargetId id, std::size_t box) const;
  void update(LiveTarget& target, std::size_t box) const;

  [[nodiscard]] const std::vector<LiveTarget>& targets() const { return targets_; }
  // Number of targets that hold points.
  [[nodiscard]] std::size_t active() const { return active_.size(); }

 private:
  // How well the frame's boxes fit a target: 0 = not at all. Counts of points (A11); in robust gated, and a box of the
  // track that gave the target its last box comes before all others while geometry does not contradict.
  [[nodiscard]] std::vector<double> scores(const LiveTarget& target, const FrameView& frame) const;
  [[nodiscard]] bool should_be_visible(const LiveTarget& target, const FrameView& frame) const;
  void check_duplicate(LiveTarget& target, std::size_t frame);
  void give_up(LiveTarget& target, const std::string& reason, std::size_t frame) const;
  void enter(LiveTarget& target, survey::TargetState state, std::size_t frame) const;

  const PreparedBoxes& prepared_;
  const DepthPrior& depth_;
  const LocateOptions& options_;
  const base::RunContext& ctx_;
  Mode mode_;
  UpdateOptions update_options_;
  std::vector<LiveTarget> targets_;  // all ever made, in order of id
  std::vector<std::size_t> active_;  // indices of those not deregistered, ascending
};

// Radius of the sphere about the mean that holds about all points [m].
[[nodiscard]] double reach_of(const Gaussian& gaussian);

}  // namespace cairn::localisation
