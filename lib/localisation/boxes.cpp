#include "localisation/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/number_text.hpp"

namespace cairn::localisation {
namespace {

using geometry::PixelBox;

std::string record_of(survey::DetectionId id) {
  return "detection " + std::to_string(id.value);
}

double overlap(const PixelBox& a, const PixelBox& b) {
  const double w = std::min(a.xmax, b.xmax) - std::max(a.xmin, b.xmin);
  const double h = std::min(a.ymax, b.ymax) - std::max(a.ymin, b.ymin);
  if (!(w > 0.0 && h > 0.0)) return 0.0;
  return w * h / (a.area() + b.area() - w * h);
}

// Why a detection cannot be used, or an empty reason.
struct Verdict {
  std::string reason, message;
};

Verdict judge(const survey::Detection& d, const LocateOptions& options) {
  const PixelBox& b = d.box;
  if (!std::isfinite(b.xmin) || !std::isfinite(b.ymin) || !std::isfinite(b.xmax) || !std::isfinite(b.ymax) ||
      !std::isfinite(d.score))
    return {"non_finite_box", "the box or its score is not a finite number"};
  if (!(b.width() > 0.0 && b.height() > 0.0))
    return {"zero_area_box", "the box is " + base::to_fixed(b.width(), 2) + " x " + base::to_fixed(b.height(), 2) +
                                 " px; both sides must be above 0"};
  if (d.score < options.min_score)
    return {"low_score", "score " + base::to_text(d.score) + " is below " + base::to_text(options.min_score)};
  return {};
}

// Which borders the box touches: across u (left or right), across v (top or bottom).
struct Edges {
  bool u = false, v = false;
};

Edges edges_of(const PixelBox& b, const survey::Camera& camera, double margin) {
  return {std::min(b.xmin, static_cast<double>(camera.width_px) - b.xmax) < margin,
          std::min(b.ymin, static_cast<double>(camera.height_px) - b.ymax) < margin};
}

// Of boxes of one class in one frame that overlap too much, all but the best (score, then lower id) go.
void drop_duplicates(std::vector<Box>& boxes, double limit, std::vector<base::Reject>& rejects) {
  std::vector<std::size_t> order(boxes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return boxes[a].score > boxes[b].score; });
  std::vector<std::size_t> kept;
  for (const std::size_t i : order) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](std::size_t k) {
      return boxes[k].object_class == boxes[i].object_class && overlap(boxes[k].ideal, boxes[i].ideal) >= limit;
    });
    if (same == kept.end()) {
      kept.push_back(i);
    } else {
      rejects.push_back(
          {record_of(boxes[i].id), "duplicate_box",
           "overlaps detection " + std::to_string(boxes[*same].id.value) + " by more than " + base::to_text(limit)});
    }
  }
  std::sort(kept.begin(), kept.end());
  std::vector<Box> result;
  for (const std::size_t k : kept) result.push_back(boxes[k]);
  boxes = std::move(result);
}

// A box and where it comes from.
struct Row {
  survey::Detection detection;
  survey::TrackId track;
};

std::string record_of(const Row& row) {
  if (row.detection.id.valid()) return record_of(row.detection.id);
  return "track " + std::to_string(row.track.value) + " at frame " + std::to_string(row.detection.frame.value);
}

std::vector<Row> rows_of(const survey::Survey& survey, const Tracks& tracks, bool paper, PreparedBoxes& result) {
  std::vector<Row> rows;
  if (!tracks) {
    for (const auto& d : survey.detections) rows.push_back({d, {}});
    return rows;
  }
  std::set<survey::DetectionId> claimed;
  for (const auto& tracked : *tracks) {
    Row row{tracked.box, tracked.track};
    if (tracked.state == survey::TrackState::coasted) {
      ++result.coasted;
      row.detection.id = {};
      if (paper) rows.push_back(std::move(row));
      continue;
    }
    const auto* detection = survey.detection(tracked.box.id);
    const std::string where =
        "track " + std::to_string(tracked.track.value) + " at frame " + std::to_string(tracked.box.frame.value);
    if (detection == nullptr || detection->frame != tracked.box.frame) {
      result.rejects.push_back({where, "unknown_detection",
                                "detection " + std::to_string(tracked.box.id.value) + " is not one of this frame"});
    } else if (!claimed.insert(detection->id).second) {
      result.rejects.push_back(
          {where, "duplicate_track_row", "detection " + std::to_string(detection->id.value) + " is in another row"});
    } else {
      if (!paper) row.detection = *detection;
      rows.push_back(std::move(row));
    }
  }
  for (const auto& d : survey.detections)
    if (!claimed.contains(d.id))
      result.rejects.push_back({record_of(d.id), "unregistered", "no registered track holds this box"});
  return rows;
}

bool is_video(const std::vector<FrameView>& frames) {
  constexpr std::size_t kLeastFrames = 100;
  constexpr double kLongestStep_s = 2.0;
  if (frames.size() < kLeastFrames) return false;
  std::vector<std::int64_t> steps;
  for (std::size_t f = 1; f < frames.size(); ++f) steps.push_back(frames[f].time_ns - frames[f - 1].time_ns);
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  const double step = 1e-9 * static_cast<double>(steps[steps.size() / 2]);
  return step > 0.0 && step <= kLongestStep_s;
}

}  // namespace

base::Reject edge_reject(survey::DetectionId id) {
  return {record_of(id), "edge", "the box touches the image border, and no target was found that it is a part of"};
}

PreparedBoxes prepare_boxes(const survey::Survey& survey, const LocateOptions& options, const Tracks& tracks) {
  PreparedBoxes result;
  const bool paper = mode_of(options) == Mode::paper;
  FrameViews views = frame_views(survey, options, result.rejects);
  result.frames = std::move(views.frames);
  result.clock_jumps = views.clock_jumps;
  result.tracked = tracks.has_value();
  result.video = result.tracked || is_video(result.frames);
  const std::vector<Row> rows = rows_of(survey, tracks, paper, result);

  std::set<std::string> names;
  for (const auto& row : rows) names.insert(row.detection.object_class);
  result.classes.assign(names.begin(), names.end());

  std::vector<std::vector<Box>> by_frame(result.frames.size());
  for (const auto& row : rows) {
    const survey::Detection& d = row.detection;
    const auto reject = [&](std::string reason, std::string message) {
      result.rejects.push_back({record_of(row), std::move(reason), std::move(message)});
    };
    const auto at = views.index.find(d.frame);
    if (at == views.index.end()) {
      const auto why = views.unusable.find(d.frame);
      reject(why == views.unusable.end() ? "unknown_frame" : why->second,
             "frame " + std::to_string(d.frame.value) + " cannot be used");
      continue;
    }
    const FrameView& frame = result.frames[at->second];
    auto verdict = judge(d, options);
    if (!verdict.reason.empty()) {
      reject(std::move(verdict.reason), std::move(verdict.message));
      continue;
    }
    const Edges edges = edges_of(d.box, *frame.camera, options.edge_margin_px);
    const bool cut = edges.u || edges.v;
    if (cut && paper) {
      reject("edge", edge_reject(d.id).message);
      continue;
    }
    const auto ideal = undistorted(*frame.camera, d.box);
    const auto centre = undistorted(*frame.camera, d.box.centre());
    if (!ideal || !centre) {
      reject("cannot_undistort", "the lens model has no ray for this box, or it lies over 80 deg off the axis");
      continue;
    }
    Box box;
    box.id = d.id;
    box.track = row.track;
    box.frame = at->second;
    box.object_class = static_cast<std::size_t>(
        std::lower_bound(result.classes.begin(), result.classes.end(), d.object_class) - result.classes.begin());
    box.ideal = *ideal;
    box.centre_px = *centre;
    const double sigma = std::hypot(options.sigma_px, options.sigma_size * 0.5 * (ideal->width() + ideal->height()));
    const double hidden = 0.5 * std::max(ideal->width(), ideal->height());
    box.sigma_px = {std::hypot(sigma, edges.u ? hidden : 0.0), std::hypot(sigma, edges.v ? hidden : 0.0)};
    box.cut = cut;
    box.score = d.score;
    by_frame[at->second].push_back(box);
  }
  for (std::size_t f = 0; f < by_frame.size(); ++f) {
    auto& boxes = by_frame[f];
    std::sort(boxes.begin(), boxes.end(),
              [](const Box& a, const Box& b) { return a.id != b.id ? a.id < b.id : a.track < b.track; });
    if (!paper) drop_duplicates(boxes, options.duplicate_iou, result.rejects);
    for (const auto& box : boxes) {
      (box.cut ? result.frames[f].cut_boxes : result.frames[f].boxes).push_back(result.boxes.size());
      result.boxes.push_back(box);
    }
  }
  return result;
}

}  // namespace cairn::localisation
