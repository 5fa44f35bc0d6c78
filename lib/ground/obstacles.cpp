#include "ground/obstacles.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "camera/projection.hpp"

namespace cairn::ground {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using survey::ObstacleKind;
using survey::Target;
using survey::TargetState;

constexpr double kUnknownShape = 0.5;  // height / width where no ground says how high an object is (boulders, cars)

int rank_of(TargetState state) {
  switch (state) {
    case TargetState::deregistered: return -1;
    case TargetState::generated: return 0;
    case TargetState::converging: return 1;
    case TargetState::converged: return 2;
    case TargetState::mapped: return 3;
  }
  return -1;
}

// Rows of d pixel / d position, by central differences through the lens model.
struct PixelSlopes {
  Vec3 u = Vec3::Zero(), v = Vec3::Zero();  // px / m
};

std::optional<PixelSlopes> slopes(const survey::Camera& camera, const geometry::RigidTransform& T, const Vec3& at) {
  constexpr double kStep = 0.01;  // m
  PixelSlopes result;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 step = kStep * Vec3::Unit(axis);
    const auto ahead = camera::project_world(camera, T, at + step),
               behind = camera::project_world(camera, T, at - step);
    if (!ahead || !behind) return std::nullopt;
    const Vec2 slope = (*ahead - *behind) / (2.0 * kStep);
    result.u[axis] = slope.x();
    result.v[axis] = slope.y();
  }
  return result;
}

// Diameter of the upright cylinder that fills the box; height empty = half as high as wide.
std::optional<double> diameter(const PixelSlopes& s, const geometry::PixelBox& box, std::optional<double> height) {
  double widest = 0.0;
  const auto along = [&](const Vec3& slope, double extent_px) {
    const double level = slope.head<2>().norm(), upright = std::abs(slope.z());
    // An axis that mostly shows the height says little about the width.
    if (!(level > upright)) return;
    const double d = height ? (extent_px - *height * upright) / level : extent_px / (level + kUnknownShape * upright);
    if (std::isfinite(d)) widest = std::max(widest, d);
  };
  along(s.u, box.width());
  along(s.v, box.height());
  if (!(widest > 0.0)) return std::nullopt;
  return widest;
}

bool whole(const survey::Camera& camera, const geometry::PixelBox& b, double margin) {
  return b.width() > 0.0 && b.height() > 0.0 && std::min(b.xmin, b.ymin) >= margin &&
         static_cast<double>(camera.width_px) - b.xmax >= margin &&
         static_cast<double>(camera.height_px) - b.ymax >= margin;
}

struct Width {
  double value = 0.0, sigma = 0.0;  // m; sigma 0 = not known
};

double median_of(std::vector<double>& values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

// Median diameter over the target's whole boxes, and its standard error from the median absolute deviation.
std::optional<Width> width_from_boxes(const Target& target, const survey::Survey& survey, std::optional<double> height,
                                      double margin) {
  std::vector<double> widths;
  for (const auto id : target.detections) {
    const auto* detection = survey.detection(id);
    const auto* frame = detection == nullptr ? nullptr : survey.frame(detection->frame);
    const auto* camera = frame == nullptr ? nullptr : survey.camera(frame->camera);
    if (camera == nullptr || !whole(*camera, detection->box, margin)) continue;
    const auto s = slopes(*camera, frame->T_world_camera, target.centre);
    if (!s) continue;
    if (const auto d = diameter(*s, detection->box, height)) widths.push_back(*d);
  }
  if (widths.empty()) return std::nullopt;
  Width result{median_of(widths), 0.0};
  if (widths.size() < 3) return result;
  for (double& w : widths) w = std::abs(w - result.value);
  constexpr double kMadToSigma = 1.4826, kMedianLoss = 1.2533;  // of normal values
  result.sigma = kMadToSigma * kMedianLoss * median_of(widths) / std::sqrt(static_cast<double>(widths.size()));
  return result;
}

void add_history(survey::Obstacle& o, const Target& target, const survey::Survey& survey) {
  bool any = false;
  double farthest = 0.0;
  for (const auto id : target.detections) {
    const auto* detection = survey.detection(id);
    const auto* frame = detection == nullptr ? nullptr : survey.frame(detection->frame);
    if (frame == nullptr) continue;
    o.first_seen_ns = any ? std::min(o.first_seen_ns, frame->time_ns) : frame->time_ns;
    o.last_seen_ns = any ? std::max(o.last_seen_ns, frame->time_ns) : frame->time_ns;
    farthest = std::max(farthest, (frame->T_world_camera.translation - target.centre).norm());
    any = true;
  }
  if (!any) return;
  constexpr double kBorder = 0.02;  // of the image's sides
  for (const auto& frame : survey.frames) {
    if (frame.time_ns <= o.last_seen_ns) continue;
    const auto* camera = survey.camera(frame.camera);
    if (camera == nullptr || (frame.T_world_camera.translation - target.centre).norm() > 2.0 * farthest) continue;
    const auto pixel = camera::project_world(*camera, frame.T_world_camera, target.centre);
    if (pixel && camera::inside_image(*camera, *pixel, kBorder)) ++o.misses;
  }
}

std::string record_of(const Target& target) {
  return "target " + std::to_string(target.id.value);
}

}  // namespace

void ObstacleOptions::visit(base::OptionVisitor& v) {
  classes.visit(v);
  v.choice("least-state", least_state, {"generated", "converging", "converged"},
           "targets of a lower state are left out");
  v.real("edge-margin-px", edge_margin_px, 0.0, 1e4, "boxes nearer to the image border are not measured");
  v.real("min-height-m", min_height_m, 0.0, 100.0, "least height of an object");
}

ObstacleResult make_obstacles(std::span<const Target> targets, const survey::Survey& survey, const GroundHeight& ground,
                              const ObstacleOptions& options, base::RunContext& ctx) {
  base::validate(
      [&options](base::OptionVisitor& v) {
        ObstacleOptions copy = options;
        copy.visit(v);
      },
      "obstacles");
  const auto least = survey::target_state_from(options.least_state).value_or(TargetState::converging);
  ObstacleResult result;
  std::set<std::string> unknown;
  for (const auto& target : targets) {
    if (target.state == TargetState::deregistered) {
      result.rejects.push_back({record_of(target), "target_deregistered", "the target was given up"});
      continue;
    }
    if (rank_of(target.state) < rank_of(least) || !target.centre.allFinite() || !target.covariance.allFinite()) {
      result.rejects.push_back(
          {record_of(target), "not_located",
           "its state is " + std::string(survey::name_of(target.state)) + "; " + options.least_state + " is needed"});
      continue;
    }
    survey::Obstacle o;
    o.target = target.id;
    o.object_class = target.object_class;
    const auto kind = kind_of_class(target.object_class, options.classes);
    if (!kind && unknown.insert(target.object_class).second) {
      result.unknown_classes.push_back(target.object_class);
      ctx.warn("obstacles: class '" + target.object_class + "' is in no table; it is taken as an obstacle");
    }
    o.kind = kind.value_or(ObstacleKind::obstacle);
    o.covariance = target.covariance.topLeftCorner<2, 2>();
    o.score = std::isfinite(target.mean_score) ? target.mean_score : 0.0;
    o.observations = target.detections.size();

    auto foot = ground ? ground(target.centre.x(), target.centre.y()) : std::nullopt;
    if (foot && !std::isfinite(*foot)) foot.reset();
    std::optional<double> height;
    if (foot) height = std::max(options.min_height_m, 2.0 * (target.centre.z() - *foot));
    auto width = width_from_boxes(target, survey, height, options.edge_margin_px);
    if (!width && target.bcylinder && target.bcylinder->radius > 0.0 && std::isfinite(target.bcylinder->radius))
      width = Width{2.0 * target.bcylinder->radius, 0.0};
    if (!width) {
      result.rejects.push_back(
          {record_of(target), "no_size", "no whole box and no bounding cylinder to measure it by"});
      continue;
    }
    o.width_m = width->value;
    o.sigma_width_m = std::isfinite(width->sigma) ? width->sigma : 0.0;
    o.height_m = height.value_or(std::max(options.min_height_m, kUnknownShape * o.width_m));
    o.sigma_height_m = foot ? 2.0 * std::sqrt(std::max(0.0, target.covariance(2, 2))) : 0.0;
    add_history(o, target, survey);
    if (!foot) ++result.without_ground;
    o.position = {target.centre.x(), target.centre.y(), foot.value_or(target.centre.z() - 0.5 * o.height_m)};
    result.obstacles.push_back(std::move(o));
  }
  return result;
}

}  // namespace cairn::ground
