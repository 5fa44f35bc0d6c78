// Trajectories against their truth: absolute and relative errors (Sturm et al. 2012).
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "base/options.hpp"
#include "evaluation/statistics.hpp"
#include "geometry/rigid_transform.hpp"

namespace cairn::evaluation {

struct StampedPose {
  std::int64_t time_ns = 0;
  std::int64_t id = -1;                   // of the frame; -1 = has none
  geometry::RigidTransform T_world_body;  // m
};

enum class Alignment { none, translation, se3, sim3 };

struct TrajectoryOptions {
  // What is fitted to the truth before the errors are taken: nothing; a shift (mean of differences); rotation and
  // shift; rotation, shift and scale (Umeyama 1991).
  std::string align = "se3";
  double max_difference_s = 0.02;  // of the times of a pair
  double time_offset_s = 0.0;      // added to the estimate's times
  double delta = 1.0;              // of the relative error
  std::string delta_unit = "frames";

  void visit(base::OptionVisitor& visitor) {
    visitor.choice("align", align, {"none", "translation", "se3", "sim3"},
                   "what is fitted to the truth before errors are taken");
    visitor.real("max-difference-s", max_difference_s, 0.0, 3600.0, "greatest difference of the times of a pair, s");
    visitor.real("time-offset-s", time_offset_s, -1e9, 1e9, "added to the estimate's times, s");
    visitor.real("delta", delta, 1e-9, 1e9, "step of the relative error");
    visitor.choice("delta-unit", delta_unit, {"frames", "seconds", "metres"}, "unit of --delta");
  }
};
[[nodiscard]] Alignment alignment_of(const TrajectoryOptions& options);

// Index pairs (estimate, truth), ascending in the estimate. By time: all pairs within max_difference, those of the
// least difference first, each pose once (as the TUM benchmark's tool). Order of the inputs does not matter.
// Cost n log n for sparse matches.
using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
[[nodiscard]] Pairs pairs_by_time(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth,
                                  const TrajectoryOptions& options);
// By id, in the order of the estimate's times.
[[nodiscard]] Pairs pairs_by_id(const std::vector<StampedPose>& estimate, const std::vector<StampedPose>& truth);

// Least squares of |truth - S estimate|^2 over points (Umeyama 1991, equations 40 to 43). `from` and `to` of one
// length. Throws failed_precondition for fewer than 3 points (se3, sim3; 1 for translation), or points that all
// coincide where a scale is asked for.
[[nodiscard]] geometry::Similarity align_points(const std::vector<geometry::Vec3>& from,
                                                const std::vector<geometry::Vec3>& to, Alignment alignment);

struct TrajectoryErrors {
  std::size_t pairs = 0;
  geometry::Similarity T_truth_estimate;  // the alignment that was applied
  Spread ate_m;                           // |truth - aligned estimate| of positions, m
  Spread ate_rotation_deg;                // angle between aligned estimate and truth, deg
  std::size_t relative_pairs = 0;
  Spread rpe_m, rpe_rotation_deg;         // of E = (Q_i^-1 Q_j)^-1 (P_i^-1 P_j), P the (scaled) estimate, Q the truth
  std::vector<double> position_errors_m;  // by pair
};

// RPE takes every pair (i, j): j = i + delta frames, or the first j at least delta seconds (of the estimate's times) or
// metres (of the truth's path) later, left out where it is more than a tenth of delta too late.
// Throws failed_precondition where there are too few pairs.
[[nodiscard]] TrajectoryErrors score_trajectory(const std::vector<StampedPose>& estimate,
                                                const std::vector<StampedPose>& truth, const Pairs& pairs,
                                                const TrajectoryOptions& options);

}  // namespace cairn::evaluation
