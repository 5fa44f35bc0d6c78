#include "localisation/locate.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/parallel.hpp"
#include "localisation/consensus.hpp"
#include "localisation/drift.hpp"
#include "localisation/target_records.hpp"
#include "localisation/tracker.hpp"

namespace cairn::localisation {
namespace {

using survey::Target;
using survey::TargetState;

// Gates too narrow for the survey's real errors cost targets: the consensus is repeated with errors as the residuals
// show them. What remains of the scale, below 1 too, goes into the covariances alone.
void adapt_noise(PreparedBoxes& prepared, const DepthPrior& depth, const PointsTracker& tracker,
                 const LocateOptions& options, const base::RunContext& ctx, Consensus& consensus, double& total) {
  constexpr int kRounds = 2;
  constexpr double kNegligible = 1.25, kMostAtOnce = 4.0;
  for (int round = 0; round < kRounds; ++round) {
    const double factor = std::min(noise_scale(prepared, consensus).value_or(1.0), kMostAtOnce);
    if (factor < kNegligible) break;
    total *= factor;
    for (auto& frame : prepared.frames) {
      frame.sigma_xy_m *= factor;
      frame.sigma_z_m *= factor;
      frame.sigma_rot_rad *= factor;
    }
    for (auto& box : prepared.boxes) box.sigma_px *= factor;
    consensus = find_consensus(prepared, depth, tracker.targets(), options, ctx);
  }
  const double rest = noise_scale(prepared, consensus).value_or(1.0);
  total *= rest;
  for (auto& c : consensus.candidates) c.fix.covariance *= rest * rest;
}

// Errors that more boxes do not average out.
void add_common_errors(const std::map<survey::TargetId, geometry::Mat3>& wander, const LocateOptions& options,
                       Consensus& consensus) {
  constexpr double kInHeight = 1.5;
  geometry::Mat3 widest = geometry::Mat3::Zero();
  for (const auto& [id, covariance] : wander)
    if (covariance.trace() > widest.trace()) widest = covariance;
  for (auto& c : consensus.candidates) {
    const double level = options.outline_sigma * c.size_m;
    const geometry::Vec3 sigma(level, level, kInHeight * level);
    const auto at = wander.find(c.id);
    c.drift_covariance = at == wander.end() ? widest : at->second;
    c.common_covariance = c.drift_covariance + geometry::Mat3(sigma.cwiseAbs2().asDiagonal());
  }
}

void collect(const PreparedBoxes& prepared, std::vector<TargetRecord> outputs, LocateResult& result) {
  std::sort(outputs.begin(), outputs.end(), [](const auto& a, const auto& b) { return a.target.id < b.target.id; });
  for (auto& out : outputs) {
    Target& t = out.target;
    // Points flung out by a hopeless input must not carry a non-finite number into a file.
    if (!t.centre.allFinite() || !t.covariance.allFinite()) {
      for (const auto id : t.detections)
        result.rejects.push_back({"detection " + std::to_string(id.value), "non_finite_target",
                                  "target " + std::to_string(t.id.value) + " has no finite centre"});
      continue;
    }
    switch (t.state) {
      case TargetState::generated: ++result.counts.generated; break;
      case TargetState::converging: ++result.counts.converging; break;
      case TargetState::converged:
      case TargetState::mapped: ++result.counts.converged; break;
      case TargetState::deregistered: ++result.counts.deregistered; break;
    }
    result.counts.used += t.detections.size();
    result.targets.push_back(std::move(t));
    result.evidence.push_back(out.evidence);
    result.points.push_back(std::move(out.points));
  }
  result.counts.frames = prepared.frames.size();
}

}  // namespace

LocateResult locate(const survey::Survey& survey, const LocateOptions& options, base::RunContext& ctx,
                    const DepthBound& bound) {
  return locate(survey, std::nullopt, options, ctx, bound);
}

LocateResult locate(const survey::Survey& survey, const Tracks& tracks, const LocateOptions& given,
                    base::RunContext& ctx, const DepthBound& bound) {
  const LocateOptions options = resolved(given, tracks.has_value());
  LocateResult result;
  PreparedBoxes prepared = prepare_boxes(survey, options, tracks);
  const DepthPrior depth(survey, prepared, options, bound);
  result.rejects = prepared.rejects;
  result.counts.detections = survey.detections.size();
  result.counts.depth_source = depth.source();
  result.counts.coasted = prepared.coasted;
  result.counts.clock_jumps = prepared.clock_jumps;
  if (depth.source() == "default" && !prepared.boxes.empty())
    ctx.warn(
        "locate: nothing says how far away the objects are (no tie points, terrain, --ground-up-m or "
        "--max-depth-m); 3 m to 18 m is assumed");

  PointsTracker tracker(prepared, depth, options, ctx);
  for (std::size_t f = 0; f < prepared.frames.size(); ++f) {
    ctx.check_stop();
    const std::size_t held = tracker.active() + prepared.frames[f].boxes.size();
    ctx.check_memory(held * static_cast<std::size_t>(options.points_per_target) * 3 * sizeof(double),
                     "the points of the targets");
    tracker.step(f);
    ctx.progress("frames", f + 1, prepared.frames.size());
  }

  std::vector<TargetRecord> outputs;
  if (mode_of(options) == Mode::paper) {
    for (const auto& live : tracker.targets()) outputs.push_back(paper_record(prepared, live));
  } else {
    Consensus consensus = find_consensus(prepared, depth, tracker.targets(), options, ctx);
    std::map<survey::TargetId, geometry::Mat3> wander;  // of the centres of the first consensus
    if (drifts(prepared, options)) {
      const Drift drift = estimate_drift(prepared, consensus.candidates, options);
      remove_drift(drift, prepared);
      result.counts.drift_m = drift.rms_m;
      for (std::size_t f = 0; f < prepared.frames.size(); ++f)
        result.drift.emplace_back(prepared.frames[f].id, drift.offset_m[f]);
      for (std::size_t i = 0; i < consensus.candidates.size(); ++i)
        wander[consensus.candidates[i].id] = drift.covariance.at(i);
      consensus = find_consensus(prepared, depth, tracker.targets(), options, ctx);
    }
    if (!options.assumed_noise)
      adapt_noise(prepared, depth, tracker, options, ctx, consensus, result.counts.noise_scale);
    add_common_errors(wander, options, consensus);
    result.counts.merged = consensus.merged;
    result.counts.recovered = consensus.recovered;
    result.counts.moved_boxes = consensus.moved;
    std::map<survey::TargetId, std::vector<std::size_t>> left;
    for (const std::size_t b : consensus.left_over) {
      if (prepared.boxes[b].cut) result.rejects.push_back(edge_reject(prepared.boxes[b].id));
      else left[consensus.seed_of_box[b]].push_back(b);
    }
    for (const auto& c : consensus.candidates) {
      const auto at = left.find(c.id);
      if (at == left.end()) continue;
      for (const std::size_t b : at->second)
        result.rejects.push_back({"detection " + std::to_string(prepared.boxes[b].id.value), "box_outlier",
                                  "does not agree with the other boxes of target " + std::to_string(c.id.value)});
      left.erase(at);
    }
    const std::vector<std::pair<survey::TargetId, std::vector<std::size_t>>> alone(left.begin(), left.end());
    outputs.resize(consensus.candidates.size() + alone.size());
    constexpr std::size_t kGrain = 4;  // targets; each takes some updates of the points
    base::parallel_for(outputs.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t known = consensus.candidates.size();
        outputs[i] = i < known
                         ? robust_record(prepared, tracker, consensus.candidates[i], options)
                         : leftover_record(prepared, tracker, alone[i - known].first, alone[i - known].second, options);
      }
    });
  }
  collect(prepared, std::move(outputs), result);
  result.counts.rejected = result.counts.detections - result.counts.used;
  return result;
}

survey::Survey without_drift(survey::Survey survey, const LocateResult& result) {
  const std::map<survey::FrameId, geometry::Vec3> offset(result.drift.begin(), result.drift.end());
  for (auto& frame : survey.frames)
    if (const auto at = offset.find(frame.id); at != offset.end()) frame.T_world_camera.translation -= at->second;
  return survey;
}

}  // namespace cairn::localisation
