#include "localisation/target_records.hpp"

#include <algorithm>
#include <cmath>

#include "base/angle.hpp"
#include "localisation/bounding_cylinder.hpp"
#include "localisation/history.hpp"
#include "localisation/triangulation.hpp"

namespace cairn::localisation {
namespace {

using survey::Target;
using survey::TargetState;

// Record fields that come from the points and the boxes, whatever the mode.
TargetRecord filter_record(const PreparedBoxes& prepared, const LiveTarget& live,
                           const std::vector<std::size_t>& boxes) {
  TargetRecord out;
  Target& t = out.target;
  t.id = live.id;
  t.object_class = prepared.classes[live.object_class];
  t.state = live.state;
  t.history = live.history;
  t.entropy_nats = live.entropy_nats;
  t.divergence = live.divergence;
  for (const std::size_t f : live.keyframes) t.keyframes.push_back(prepared.frames[f].id);
  double score = 0.0;
  for (const std::size_t b : boxes) {
    if (prepared.boxes[b].id.valid()) t.detections.push_back(prepared.boxes[b].id);
    score += prepared.boxes[b].score;
  }
  std::sort(t.detections.begin(), t.detections.end());
  t.mean_score = score / static_cast<double>(boxes.size());
  t.reasons = live.reasons;
  t.centre = live.gaussian.mean;
  t.covariance = live.gaussian.covariance;
  t.bcylinder = live.cylinder ? *live.cylinder : bounding_cylinder(live.points);
  out.evidence.boxes = boxes.size();
  out.evidence.size_m = live.size_m;
  out.evidence.points_mean = live.gaussian.mean;
  out.evidence.points_covariance = live.gaussian.covariance;
  out.points = live.points;
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

// Points of targets that were given up say nothing, and there may be many.
void drop_points_where_given_up(TargetRecord& record) {
  if (record.target.state == TargetState::deregistered) record.points = Points(0, 3);
}

}  // namespace

TargetRecord paper_record(const PreparedBoxes& prepared, const LiveTarget& live) {
  TargetRecord out = filter_record(prepared, live, live.boxes);
  out.target.reasons.emplace_back("covariance_is_spread");
  return out;
}

TargetRecord robust_record(const PreparedBoxes& prepared, const PointsTracker& tracker, const Candidate& c,
                           const LocateOptions& options) {
  std::vector<std::size_t> whole;
  for (const std::size_t b : c.boxes)
    if (!prepared.boxes[b].cut) whole.push_back(b);
  const LiveTarget live = filtered(tracker, prepared, c.id, whole);
  TargetRecord out = filter_record(prepared, live, c.boxes);
  Target& t = out.target;
  t.centre = c.fix.centre;
  t.covariance = c.fix.covariance + c.common_covariance;
  out.evidence.visible_frames = c.visible_frames;
  out.evidence.drift_covariance = c.drift_covariance;
  out.evidence.rms_px = c.fix.rms_px;
  out.evidence.parallax_deg = base::rad_to_deg(c.fix.parallax_rad);
  out.evidence.size_m = c.size_m;
  Stages stages = stages_of(prepared, c, live, options);
  t.state = stages.history.back().state;
  t.history = std::move(stages.history);
  t.reasons.insert(t.reasons.end(), stages.missing.begin(), stages.missing.end());
  drop_points_where_given_up(out);
  return out;
}

TargetRecord leftover_record(const PreparedBoxes& prepared, const PointsTracker& tracker, survey::TargetId id,
                             const std::vector<std::size_t>& boxes, const LocateOptions& options) {
  const LiveTarget live = filtered(tracker, prepared, id, boxes);
  TargetRecord out = filter_record(prepared, live, live.boxes);
  Target& t = out.target;
  std::vector<geometry::Vec3> directions;
  for (const std::size_t b : boxes)
    directions.push_back(
        prepared.frames[prepared.boxes[b].frame].view.direction(prepared.boxes[b].centre_px).normalized());
  out.evidence.parallax_deg = base::rad_to_deg(widest_angle(directions));
  t.history.clear();
  const auto enter = [&](TargetState state, std::size_t box) {
    t.history.push_back({state, prepared.frames[prepared.boxes[box].frame].id});
    t.state = state;
  };
  const auto least = static_cast<std::size_t>(options.generation_boxes);
  if (boxes.size() >= least && out.evidence.parallax_deg < options.min_parallax_deg) {
    // All from one direction: something is there, how far away is not known.
    enter(TargetState::generated, live.boxes[least - 1]);
    if (live.state != TargetState::generated) enter(TargetState::converging, live.boxes.back());
    t.reasons.emplace_back("one_direction");
  } else {
    enter(TargetState::deregistered, live.boxes.back());
    t.reasons.emplace_back(boxes.size() == 1                                      ? "seen_once"
                           : out.evidence.parallax_deg < options.min_parallax_deg ? "too_few_boxes"
                                                                                  : "inconsistent_boxes");
  }
  drop_points_where_given_up(out);
  return out;
}

}  // namespace cairn::localisation
