#include "localisation/locate.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "base/angle.hpp"
#include "base/parallel.hpp"
#include "localisation/bounding_cylinder.hpp"
#include "localisation/consensus.hpp"
#include "localisation/tracker.hpp"

namespace cairn::localisation {
namespace {

using survey::Target;
using survey::TargetState;

constexpr double kSigmaShare = 0.25;  // of the size: a large object's outline has no sharper centre

struct Output {
  Target target;
  TargetEvidence evidence;
  Points points;
};

// Record fields that come from the points and the boxes, whatever the mode.
void fill_from_filter(const PreparedBoxes& prepared, const LiveTarget& live, const std::vector<std::size_t>& boxes,
                      Output& out) {
  Target& t = out.target;
  t.id = live.id;
  t.object_class = prepared.classes[live.object_class];
  t.entropy_nats = live.entropy_nats;
  t.divergence = live.divergence;
  for (const std::size_t f : live.keyframes) t.keyframes.push_back(prepared.frames[f].id);
  double score = 0.0;
  for (const std::size_t b : boxes) {
    t.detections.push_back(prepared.boxes[b].id);
    score += prepared.boxes[b].score;
  }
  std::sort(t.detections.begin(), t.detections.end());
  t.mean_score = score / static_cast<double>(boxes.size());
  t.reasons = live.reasons;
  t.centre = live.gaussian.mean;
  t.covariance = live.gaussian.covariance;
  t.bcylinder = bounding_cylinder(live.points);
  out.evidence.boxes = boxes.size();
  out.evidence.size_m = live.size_m;
  out.evidence.points_mean = live.gaussian.mean;
  out.evidence.points_covariance = live.gaussian.covariance;
  out.points = live.points;
}

Output paper_target(const PreparedBoxes& prepared, const LiveTarget& live) {
  Output out;
  fill_from_filter(prepared, live, live.boxes, out);
  out.target.state = live.state;
  out.target.reasons.emplace_back("covariance_is_spread");
  return out;
}

// The filter over the final boxes of a target, in the order of the frames.
LiveTarget filtered(const PointsTracker& tracker, const PreparedBoxes& prepared, survey::TargetId id,
                    std::vector<std::size_t> boxes) {
  std::sort(boxes.begin(), boxes.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(prepared.boxes[a].frame, a) < std::pair(prepared.boxes[b].frame, b);
  });
  LiveTarget live = tracker.generate(id, boxes.front());
  for (std::size_t i = 1; i < boxes.size(); ++i) tracker.update(live, boxes[i]);
  return live;
}

Output robust_target(const PreparedBoxes& prepared, const PointsTracker& tracker, const Candidate& c,
                     const LocateOptions& options) {
  Output out;
  std::vector<std::size_t> whole;
  for (const std::size_t b : c.boxes)
    if (!prepared.boxes[b].cut) whole.push_back(b);
  const LiveTarget live = filtered(tracker, prepared, c.id, whole);
  fill_from_filter(prepared, live, c.boxes, out);
  Target& t = out.target;
  t.centre = c.fix.centre;
  t.covariance = c.fix.covariance;
  out.evidence.visible_frames = c.visible_frames;
  out.evidence.rms_px = c.fix.rms_px;
  out.evidence.parallax_deg = base::rad_to_deg(c.fix.parallax_rad);
  out.evidence.size_m = c.size_m;

  const double hits = static_cast<double>(c.boxes.size());
  const bool rare = hits < options.min_hit_ratio * static_cast<double>(c.visible_frames);
  std::vector<std::string> missing;
  if (c.boxes.size() < static_cast<std::size_t>(options.min_boxes)) missing.emplace_back("too_few_boxes");
  if (out.evidence.parallax_deg < options.min_parallax_deg) missing.emplace_back("one_direction");
  const double allowed = std::max(options.max_sigma_m, kSigmaShare * c.size_m);
  if (c.fix.covariance.diagonal().maxCoeff() > allowed * allowed) missing.emplace_back("uncertain_centre");
  if (rare) missing.emplace_back("rarely_seen");
  if (missing.empty()) {
    t.state = TargetState::converged;
  } else if (rare) {
    t.state = TargetState::deregistered;
  } else {
    t.state = live.state == TargetState::generated ? TargetState::generated : TargetState::converging;
  }
  t.reasons.insert(t.reasons.end(), missing.begin(), missing.end());
  return out;
}

// What is left of a tracker's target when the consensus took none of its boxes.
Output leftover_target(const PreparedBoxes& prepared, const PointsTracker& tracker, survey::TargetId id,
                       const std::vector<std::size_t>& boxes, const LocateOptions& options) {
  Output out;
  const LiveTarget live = filtered(tracker, prepared, id, boxes);
  fill_from_filter(prepared, live, live.boxes, out);
  double parallax = 0.0;
  for (const std::size_t a : boxes)
    for (const std::size_t b : boxes) {
      const auto direction = [&](std::size_t i) {
        return prepared.frames[prepared.boxes[i].frame].view.direction(prepared.boxes[i].centre_px);
      };
      parallax =
          std::max(parallax, std::atan2(direction(a).cross(direction(b)).norm(), direction(a).dot(direction(b))));
    }
  out.evidence.parallax_deg = base::rad_to_deg(parallax);
  if (boxes.size() == 1) {
    out.target.state = TargetState::deregistered;
    out.target.reasons.emplace_back("seen_once");
  } else if (out.evidence.parallax_deg < options.min_parallax_deg) {
    out.target.state = live.state == TargetState::generated ? TargetState::generated : TargetState::converging;
    out.target.reasons.emplace_back("one_direction");
  } else {
    out.target.state = TargetState::deregistered;
    out.target.reasons.emplace_back("inconsistent_boxes");
  }
  return out;
}

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

void collect(const PreparedBoxes& prepared, std::vector<Output> outputs, LocateResult& result) {
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

LocateResult locate(const survey::Survey& survey, const LocateOptions& given, base::RunContext& ctx,
                    const DepthBound& bound) {
  const LocateOptions options = resolved(given);
  LocateResult result;
  PreparedBoxes prepared = prepare_boxes(survey, options);
  const DepthPrior depth(survey, prepared, options, bound);
  result.rejects = prepared.rejects;
  result.counts.detections = survey.detections.size();
  result.counts.depth_source = depth.source();
  if (depth.source() == "default" && !prepared.boxes.empty())
    ctx.warn(
        "locate: nothing says how far away the objects are (no tie points, terrain, --ground-up-m or "
        "--max-depth-m); 3 m to 18 m is assumed");
  ctx.check_memory(prepared.boxes.size() * static_cast<std::size_t>(options.points_per_target) * 3 * sizeof(double),
                   "the points of the targets");

  PointsTracker tracker(prepared, depth, options, ctx);
  for (std::size_t f = 0; f < prepared.frames.size(); ++f) {
    ctx.check_stop();
    tracker.step(f);
    ctx.progress("frames", f + 1, prepared.frames.size());
  }

  std::vector<Output> outputs;
  if (mode_of(options) == Mode::paper) {
    for (const auto& live : tracker.targets()) outputs.push_back(paper_target(prepared, live));
  } else {
    Consensus consensus = find_consensus(prepared, depth, tracker.targets(), options, ctx);
    if (!options.assumed_noise)
      adapt_noise(prepared, depth, tracker, options, ctx, consensus, result.counts.noise_scale);
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
                         ? robust_target(prepared, tracker, consensus.candidates[i], options)
                         : leftover_target(prepared, tracker, alone[i - known].first, alone[i - known].second, options);
      }
    });
  }
  collect(prepared, std::move(outputs), result);
  result.counts.rejected = result.counts.detections - result.counts.used;
  return result;
}

}  // namespace cairn::localisation
