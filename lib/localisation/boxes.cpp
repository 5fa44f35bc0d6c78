#include "localisation/boxes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/angle.hpp"
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

bool usable_pose(const geometry::RigidTransform& T) {
  return T.rotation.allFinite() && T.translation.allFinite();
}

FrameView frame_view(const survey::Frame& frame, const survey::Camera& camera, const LocateOptions& options) {
  FrameView result;
  result.id = frame.id;
  result.camera = &camera;
  result.view = ideal_view(camera, frame.T_world_camera);
  const auto known = [](double sigma) { return std::isfinite(sigma) && sigma > 0.0 ? sigma : 0.0; };
  result.sigma_xy_m = options.pose_sigma_m >= 0.0 ? options.pose_sigma_m : known(frame.sigma_xy_m);
  result.sigma_z_m = options.pose_sigma_m >= 0.0 ? options.pose_sigma_m : known(frame.sigma_z_m);
  result.sigma_rot_rad =
      base::deg_to_rad(options.pose_sigma_deg >= 0.0 ? options.pose_sigma_deg : known(frame.sigma_rot_deg));
  return result;
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

}  // namespace

base::Reject edge_reject(survey::DetectionId id) {
  return {record_of(id), "edge", "the box touches the image border, and no target was found that it is a part of"};
}

PreparedBoxes prepare_boxes(const survey::Survey& survey, const LocateOptions& options) {
  PreparedBoxes result;
  std::map<survey::FrameId, std::string> unusable;
  std::vector<std::pair<std::int64_t, FrameView>> timed;
  for (const auto& frame : survey.frames) {
    const auto* camera = survey.camera(frame.camera);
    const std::string record = "frame " + std::to_string(frame.id.value);
    if (camera == nullptr) {
      unusable[frame.id] = "unknown_camera";
      result.rejects.push_back(
          {record, "unknown_camera", "camera " + std::to_string(frame.camera.value) + " is not in the survey"});
    } else if (!usable_pose(frame.T_world_camera)) {
      unusable[frame.id] = "bad_pose";
      result.rejects.push_back({record, "bad_pose", "the pose is not finite"});
    } else {
      timed.emplace_back(frame.time_ns, frame_view(frame, *camera, options));
    }
  }
  std::stable_sort(timed.begin(), timed.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.id < b.second.id;
  });
  std::map<survey::FrameId, std::size_t> index_of;
  for (auto& [time, frame] : timed) {
    index_of[frame.id] = result.frames.size();
    result.frames.push_back(std::move(frame));
  }

  std::set<std::string> names;
  for (const auto& d : survey.detections) names.insert(d.object_class);
  result.classes.assign(names.begin(), names.end());

  std::vector<std::vector<Box>> by_frame(result.frames.size());
  for (const auto& d : survey.detections) {
    const auto at = index_of.find(d.frame);
    if (at == index_of.end()) {
      const auto why = unusable.find(d.frame);
      result.rejects.push_back({record_of(d.id), why == unusable.end() ? "unknown_frame" : why->second,
                                "frame " + std::to_string(d.frame.value) + " cannot be used"});
      continue;
    }
    const FrameView& frame = result.frames[at->second];
    const auto verdict = judge(d, options);
    if (!verdict.reason.empty()) {
      result.rejects.push_back({record_of(d.id), verdict.reason, verdict.message});
      continue;
    }
    const Edges edges = edges_of(d.box, *frame.camera, options.edge_margin_px);
    const bool cut = edges.u || edges.v;
    if (cut && mode_of(options) == Mode::paper) {
      result.rejects.push_back(edge_reject(d.id));
      continue;
    }
    const auto ideal = undistorted(*frame.camera, d.box);
    const auto centre = undistorted(*frame.camera, d.box.centre());
    if (!ideal || !centre) {
      result.rejects.push_back({record_of(d.id), "cannot_undistort",
                                "the lens model has no ray for this box, or it lies over 80 deg off the axis"});
      continue;
    }
    Box box;
    box.id = d.id;
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
    std::sort(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) { return a.id < b.id; });
    if (mode_of(options) == Mode::robust) drop_duplicates(boxes, options.duplicate_iou, result.rejects);
    for (const auto& box : boxes) {
      (box.cut ? result.frames[f].cut_boxes : result.frames[f].boxes).push_back(result.boxes.size());
      result.boxes.push_back(box);
    }
  }
  return result;
}

}  // namespace cairn::localisation
