#include "adjustment/bundle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "adjustment/bundle_covariance.hpp"
#include "adjustment/bundle_datum.hpp"
#include "adjustment/bundle_tracks.hpp"
#include "adjustment/bundle_work.hpp"
#include "adjustment/robust.hpp"
#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geometry/alignment.hpp"

namespace cairn::adjustment {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::RigidTransform;
using geometry::Vec3;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kLeastSigmaPx = 0.05;      // no measured pixel is better
constexpr std::size_t kSharedPoints = 5;    // two frames with fewer points in common do not hold one another
constexpr double kSettledSigma = 0.05;      // relative change of sigma_px below which a round changes nothing
constexpr double kSettledSelection = 5e-3;  // share of the observations

// Points where they are wanted: kept, or triangulated from the poses as they are now.
void place_points(BundleWork& work, bool first, double gate_px) {
  const Views views = work.views();
  for (std::size_t i = 0; i < work.tracks.size(); ++i) {
    auto& track = work.tracks[i];
    if (!first && track.used) continue;  // the adjusted point
    const auto found = triangulate_track(views, track, gate_px, first ? std::span<const char>() : work.held);
    const auto given = first && track.placed ? std::optional(track.p_world) : std::nullopt;
    const bool may_keep =
        given && (work.options.triangulate == "never" ||
                  (work.options.triangulate == "better" &&
                   (!found || summed_error(views, track, *given) <= summed_error(views, track, *found))));
    track.placed = found.has_value() || may_keep;
    if (!may_keep && found) track.p_world = *found;
    if (track.control >= 0 && !track.placed && !first) track.placed = true;  // its surveyed position
  }
}

void prune(BundleWork& work) {
  prune_tracks(work.views(), {work.options.min_observations, base::deg_to_rad(work.options.min_parallax_deg)},
               work.tracks, work.held);
}

// Which observations count now: those near enough to their point.
std::size_t select(BundleWork& work, double gate_px) {
  const Views views = work.views();
  std::size_t changed = 0;
  for (auto& track : work.tracks) {
    const double gate = track.control >= 0 && std::isfinite(gate_px)
                            ? work.options.outlier_sigmas * std::max(work.options.control_sigma_px, work.sigma_px)
                            : gate_px;
    for (auto& seen : track.observations) {
      const bool before = seen.used;
      seen.error_px = track.placed ? reprojection_error(views, seen, track.p_world) : kInfinite;
      seen.used = seen.error_px <= gate && std::isfinite(seen.error_px);
      changed += before != seen.used ? 1U : 0U;
    }
  }
  work.held = work.never_used;
  prune_tracks(views, {work.options.min_observations, base::deg_to_rad(work.options.min_parallax_deg)}, work.tracks,
               work.held);
  return changed;
}

std::vector<BundlePrior> priors_of(const BundleWork& work, const std::vector<std::int32_t>& groups,
                                   std::int32_t group) {
  std::vector<BundlePrior> priors;
  for (std::size_t f = 0; f < groups.size(); ++f)
    if (groups[f] == group) priors.push_back(work.priors[f]);
  return priors;
}

// Control points (not check points) used in a group, at their surveyed places.
std::vector<Vec3> control_of(const BundleWork& work, const std::vector<std::int32_t>& groups, std::int32_t group) {
  std::vector<Vec3> places;
  for (const auto& track : work.tracks) {
    if (track.control < 0 || !track.used) continue;
    for (const auto& seen : track.observations)
      if (seen.used && groups[static_cast<std::size_t>(seen.frame)] == group) {
        places.push_back(work.problem.control[static_cast<std::size_t>(track.control)].p_world);
        break;
      }
  }
  return places;
}

// Groups of frames that nothing joins are adjusted together only where each has a datum of its own; without any
// datum the largest is adjusted and aligned.
void choose_datum(BundleWork& work) {
  const auto groups = frame_groups(work.tracks, work.held, kSharedPoints);
  std::map<std::int32_t, std::size_t> sizes;
  for (const auto group : groups)
    if (group >= 0) ++sizes[group];
  std::set<std::int32_t> by_priors, by_control;
  std::int32_t largest = -1;
  for (const auto& [group, size] : sizes) {
    if (size < 2) continue;
    if (largest < 0 || size > sizes[largest]) largest = group;
    if (fixes_datum(priors_of(work, groups, group))) by_priors.insert(group);
    else if (!in_line(control_of(work, groups, group))) by_control.insert(group);
  }
  if (largest < 0)
    throw Error(ErrorCode::failed_precondition, "no two frames share enough tie points to adjust them")
        .found(std::to_string(work.tracks.size()) + " points, none of which joins two frames with " +
               std::to_string(work.options.min_observations) + " observations each")
        .allowed("at least " + std::to_string(kSharedPoints) + " common points of two frames")
        .hint("Check the tie points with 'cairn check', or find new ones with --match");
  work.gauge = by_priors.contains(largest)    ? BundleGauge::priors
               : by_control.contains(largest) ? BundleGauge::control
                                              : BundleGauge::aligned;
  for (std::size_t f = 0; f < groups.size(); ++f) {
    if (work.never_used[f] != 0) continue;
    if (groups[f] < 0) {
      work.reason[f] = "too_few_observations";
      continue;
    }
    const bool own = by_priors.contains(groups[f]) || by_control.contains(groups[f]);
    const bool kept = groups[f] == largest || (work.gauge != BundleGauge::aligned && own);
    work.reason[f] = kept ? "" : work.gauge == BundleGauge::aligned ? "not_connected" : "no_datum";
    if (!kept) work.held[f] = work.never_used[f] = 1;
  }
  prune(work);
  for (std::size_t f = 0; f < groups.size(); ++f)
    if (work.held[f] != 0 && work.reason[f].empty()) work.reason[f] = "too_few_observations";
}

// Brings a block that only control points hold to where they are, before it is adjusted.
void move_to_control(BundleWork& work) {
  std::vector<Vec3> from, to;
  for (const auto& track : work.tracks) {
    if (track.control < 0 || !track.used) continue;
    if (const auto p = triangulate_track(work.views(), track, kInfinite, work.held)) {
      from.push_back(*p);
      to.push_back(work.problem.control[static_cast<std::size_t>(track.control)].p_world);
    }
  }
  if (const auto T = geometry::align_points(from, to)) work.apply(*T);
}

// Each point's sum of squares against the median of its chi-square (2 n - 3 degrees of freedom: what its own place
// takes up; Wilson and Hilferty 1931), the median over the points, and the poses' small share: blind to outliers, and
// right for points seen twice, whose residuals along their rays' plane vanish whatever the noise.
double estimated_sigma(const BundleWork& work, const BundleSystem& system) {
  std::vector<double> variances;
  double freedom = 0.0;
  const Views views = work.views();
  for (const auto& track : work.tracks) {
    if (!track.used || track.control >= 0) continue;
    double squares = 0.0, degrees = -3.0;
    for (const auto& seen : track.observations) {
      if (!seen.used) continue;
      const auto error = reprojection_residual(views, seen, track.p_world);
      if (!error) continue;
      squares += error->squaredNorm();
      degrees += 2.0;
    }
    if (degrees < 1.0) continue;
    freedom += degrees;
    variances.push_back(squares / (degrees * std::pow(1.0 - 2.0 / (9.0 * degrees), 3)));
  }
  if (variances.empty()) return 1.0;
  double unknowns = 6.0 * static_cast<double>(system.poses.size());
  for (const auto& camera : system.cameras) unknowns += camera::intrinsics_count(camera.model, system.intrinsics);
  if (work.gauge == BundleGauge::aligned) unknowns -= 7.0;
  constexpr double kLeastRedundancy = 0.05;
  return std::sqrt(median(std::move(variances)) / std::max(kLeastRedundancy, 1.0 - unknowns / freedom));
}

// One solve with the observations selected.
BundleRound solve_round(BundleWork& work, double loss_widening, base::RunContext& ctx) {
  BundleSystem system = work.system(loss_widening);
  auto round = solve_bundle(system, {work.options.max_iterations, work.options.function_tolerance}, ctx);
  round.sigma_px = work.sigma_px;
  work.take(system);
  if (!(work.options.sigma_px > 0.0)) work.sigma_px = std::max(kLeastSigmaPx, estimated_sigma(work, system));
  return round;
}

void run_rounds(BundleWork& work, BundleResult& result, base::RunContext& ctx) {
  place_points(work, true, kInfinite);
  work.remember_start();
  static_cast<void>(select(work, kInfinite));
  choose_datum(work);
  if (work.gauge == BundleGauge::control) move_to_control(work);
  work.sigma_px = work.options.sigma_px > 0.0 ? work.options.sigma_px : 1.0;
  // The start is far off: the loss opens as wide as the errors are.
  double widening = std::max(1.0, work.median_error() / work.sigma_px);
  for (std::int64_t round = 0; round < work.options.max_rounds; ++round) {
    const double sigma_before = work.sigma_px;
    result.rounds.push_back(solve_round(work, widening, ctx));
    ctx.debug("bundle round " + std::to_string(round + 1) + ": " + std::to_string(result.rounds.back().iterations) +
              " iterations, " + result.rounds.back().termination);
    const double gate = work.options.outlier_sigmas > 0.0 ? work.options.outlier_sigmas * work.sigma_px : kInfinite;
    if (round + 1 == work.options.max_rounds) break;
    const auto used_before = work.used_observations();
    place_points(work, false, gate);
    const std::size_t changed = select(work, gate);
    choose_datum(work);
    const auto used = work.used_observations();
    result.rounds.back().removed = used_before > used ? used_before - used : 0;
    const bool settled_sigma = std::abs(work.sigma_px - sigma_before) <= kSettledSigma * sigma_before;
    const bool settled = static_cast<double>(changed) <= kSettledSelection * static_cast<double>(used_before);
    if (settled && settled_sigma && widening <= 1.0) {
      result.converged = result.rounds.back().converged;
      // The few that changed: the last solve did not know.
      if (changed > 0) result.rounds.push_back(solve_round(work, 1.0, ctx));
      break;
    }
    widening = 1.0;
  }
  if (!result.rounds.empty())
    result.converged = result.converged || (work.options.max_rounds == 1 && result.rounds.back().converged);
}

void add_covariances(BundleWork& work, BundleResult& result) {
  result.covariance_method = work.options.covariance;
  const BundleSystem system = work.system(1.0);
  if (result.covariance_method == "auto")
    result.covariance_method =
        static_cast<std::int64_t>(system.poses.size()) <= work.options.full_covariance_frames ? "full" : "block";
  if (result.covariance_method == "none") return;
  std::vector<Vec3> positions;
  for (const auto& pose : system.poses) positions.push_back(pose.translation);
  const auto constraint = work.gauge != BundleGauge::aligned ? PoseConstraint::none
                          : in_line(positions)               ? PoseConstraint::poses
                                                             : PoseConstraint::positions;
  const bool full = result.covariance_method == "full";
  const auto covariances = pose_covariances(system, constraint, full);
  // Held by priors alone, all frames share the priors' common error. It says nothing of how well they fit one another,
  // which is what a record's sigma is used for.
  const bool common = full && work.gauge == BundleGauge::priors && positions.size() >= 3 && !in_line(positions);
  const auto relative = common ? pose_covariances(system, PoseConstraint::positions, full) : covariances;
  for (std::size_t f = 0; f < work.poses.size(); ++f) {
    const auto i = work.system_index[f];
    if (i < 0) continue;
    const Mat6& c = covariances[static_cast<std::size_t>(i)];
    if (!c.allFinite() || !(c.diagonal().minCoeff() > 0.0)) continue;
    result.frame_reports[f].covariance = c;
    const Mat6& r = relative[static_cast<std::size_t>(i)];
    const Mat6& own = r.allFinite() && r.diagonal().minCoeff() > 0.0 ? r : c;
    auto& frame = result.frames[f];
    frame.sigma_xy_m = std::sqrt(0.5 * (own(3, 3) + own(4, 4)));
    frame.sigma_z_m = std::sqrt(own(5, 5));
    frame.sigma_rot_deg = base::rad_to_deg(std::sqrt(own.topLeftCorner<3, 3>().trace() / 3.0));
  }
}

}  // namespace

std::string_view name_of(BundleGauge gauge) {
  switch (gauge) {
    case BundleGauge::priors: return "priors";
    case BundleGauge::control: return "control";
    case BundleGauge::aligned: return "aligned";
  }
  return "";
}

BundleResult adjust_bundle(const BundleProblem& problem, const BundleOptions& options, base::RunContext& ctx) {
  BundleOptions checked = options;
  base::validate(base::bind_options(checked), "refine");
  BundleResult result;
  BundleWork work(problem, options, result.rejects);
  run_rounds(work, result, ctx);
  if (work.gauge == BundleGauge::aligned) {
    std::vector<RigidTransform> from, to;
    for (std::size_t f = 0; f < work.poses.size(); ++f)
      if (work.held[f] == 0) {
        from.push_back(work.poses[f]);
        to.push_back(problem.frames[f].T_world_camera);
      }
    result.alignment = align_poses(from, to);
    work.apply(result.alignment);
  }
  report_frames(work, result);
  report_control(work, result);
  add_covariances(work, result);
  report_points(work, result);
  return result;
}

}  // namespace cairn::adjustment
