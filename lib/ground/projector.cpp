#include "ground/projector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "base/number_text.hpp"
#include "camera/projection.hpp"
#include "ground/body_outline.hpp"

namespace cairn::ground {
namespace {

using geometry::Mat2;
using geometry::PixelBox;
using geometry::RigidTransform;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

struct Noise {
  double xy_m, z_m, rotation;  // rotation: rad, each axis
};

Noise pose_noise(const survey::Frame& frame, const ProjectionOptions& o) {
  const auto known = [](double value, double otherwise) {
    return std::isfinite(value) && value > 0.0 ? value : otherwise;
  };
  return {known(frame.sigma_xy_m, o.pose_noise_xy_m), known(frame.sigma_z_m, o.pose_noise_z_m),
          kRadPerDeg * known(frame.sigma_rot_deg, o.pose_noise_rot_deg)};
}

double edge_noise(double side_px, const ProjectionOptions& o) {
  return std::hypot(o.box_noise_px, o.box_noise_fraction * side_px);
}

// (B.1) to (B.3); the pixel is freed of distortion first. Empty where k <= 0.
struct PaperPoint {
  Vec3 position;
  double range;
};
std::optional<PaperPoint> paper_point(const Vec2& pixel, const survey::Camera& camera, const RigidTransform& pose,
                                      double plane_up) {
  const auto direction = camera::unproject(camera, pixel);
  if (!direction || !(direction->z() > 0.0)) return std::nullopt;
  const Vec3 to_image = pose.rotation * (*direction / direction->z());  // P_img - P_cam
  const double z_camera = pose.translation.z() - plane_up;
  const double k = z_camera / (z_camera - (z_camera + to_image.z()));
  if (!std::isfinite(k) || !(k > 0.0)) return std::nullopt;
  return PaperPoint{pose.translation + k * to_image, k * to_image.norm()};
}

base::Reject above_horizon(const std::string& record) {
  return {record, "above_horizon", "the line of sight through the box does not meet the ground"};
}
base::Reject too_far(const std::string& record, double range, double allowed) {
  return {record, "too_far",
          "the ground is " + base::to_fixed(range, 1) + " m away; at most " + base::to_fixed(allowed, 1) + " m"};
}

Projection project_paper(const PixelBox& box, const survey::Frame& frame, const survey::Camera& camera,
                         const ProjectionOptions& options, const ObjectModel& model, const std::string& record) {
  const RigidTransform& pose = frame.T_world_camera;
  const double middle = box.centre().y();
  const auto at = [&](const Vec2& pixel, const RigidTransform& from, double plane) {
    return paper_point(pixel, camera, from, plane);
  };
  const auto centre = at(box.centre(), pose, options.ground_up_m);
  const auto left = at({box.xmin, middle}, pose, options.ground_up_m),
             right = at({box.xmax, middle}, pose, options.ground_up_m);
  if (!centre || !left || !right) return above_horizon(record);
  if (!(centre->range <= options.max_range_m)) return too_far(record, centre->range, options.max_range_m);
  Projected result;
  result.position = centre->position;
  result.vehicle = model.vehicle;
  result.width_m = (right->position - left->position).head<2>().norm();

  // First order, by central differences of the same equations.
  const auto add = [&](const std::optional<PaperPoint>& ahead, const std::optional<PaperPoint>& behind, double step,
                       double sigma) {
    if (!ahead || !behind) return;
    const Vec2 moved = (ahead->position - behind->position).head<2>() * (sigma / (2.0 * step));
    result.covariance += moved * moved.transpose();
  };
  constexpr double kPixelStep = 0.01, kStep = 1e-5;  // px; m and rad
  const Noise noise = pose_noise(frame, options);
  const double across = edge_noise(box.width(), options), down = edge_noise(box.height(), options);
  const std::array<double, 2> pixel_sigma{across / std::numbers::sqrt2, down / std::numbers::sqrt2};
  for (int axis = 0; axis < 2; ++axis) {
    const Vec2 step = kPixelStep * Vec2::Unit(axis);
    add(at(box.centre() + step, pose, options.ground_up_m), at(box.centre() - step, pose, options.ground_up_m),
        kPixelStep, pixel_sigma.at(static_cast<std::size_t>(axis)));
  }
  for (int axis = 0; axis < 3; ++axis) {
    RigidTransform ahead = pose, behind = pose;
    ahead.translation[axis] += kStep;
    behind.translation[axis] -= kStep;
    add(at(box.centre(), ahead, options.ground_up_m), at(box.centre(), behind, options.ground_up_m), kStep,
        axis == 2 ? noise.z_m : noise.xy_m);
    ahead = behind = pose;
    ahead.rotation = geometry::axis_rotation(Vec3::Unit(axis), kStep) * pose.rotation;
    behind.rotation = geometry::axis_rotation(Vec3::Unit(axis), -kStep) * pose.rotation;
    add(at(box.centre(), ahead, options.ground_up_m), at(box.centre(), behind, options.ground_up_m), kStep,
        noise.rotation);
  }
  add(at(box.centre(), pose, options.ground_up_m + kStep), at(box.centre(), pose, options.ground_up_m - kStep), kStep,
      options.plane_noise_m);
  const double z_camera = pose.translation.z() - options.ground_up_m;
  result.sigma_width_m = result.width_m * std::hypot(std::numbers::sqrt2 * across / box.width(),
                                                     std::hypot(noise.z_m, options.plane_noise_m) / z_camera);
  if (!result.position.allFinite() || !result.covariance.allFinite() || !std::isfinite(result.sigma_width_m))
    return above_horizon(record);
  return result;
}

// Foot, width and height to start from: the line of sight through the box's centre meets the ground raised by half
// the object's height.
std::variant<UprightBody, base::Reject> start_of(const PixelBox& box, const survey::Camera& camera,
                                                 const RigidTransform& pose, const Ground& ground,
                                                 const ObjectModel& model, const ProjectionOptions& options,
                                                 const std::string& record) {
  const auto ray = camera::pixel_ray(camera, pose, box.centre());
  if (!ray || !(-ray->direction.z() >= std::sin(kRadPerDeg * options.min_depression_deg))) return above_horizon(record);
  const auto hit = cast_on_ground(*ray, ground, model.base_above_ground_m, options.max_range_m, options.ray_step_m);
  if (!hit)
    return base::Reject{record, "too_far",
                        "no ground within " + base::to_fixed(options.max_range_m, 1) + " m on its line of sight"};
  const double metres_per_px = hit->range / std::max(camera.fx_px, camera.fy_px);
  UprightBody body;
  body.shape = model.shape;
  body.width_m = std::max(0.01, std::min(box.width(), box.height()) * metres_per_px);
  body.height_m = model.height_by_width ? model.height * body.width_m : model.height;
  body.foot = hit->point;
  if (const auto raised = cast_on_ground(*ray, ground, model.base_above_ground_m + 0.5 * body.height_m,
                                         options.max_range_m, options.ray_step_m)) {
    body.foot = raised->point;
    body.foot.z() -= 0.5 * body.height_m;
  }
  return body;
}

Projection project_robust(const PixelBox& box, const survey::Frame& frame, const survey::Camera& camera,
                          const Ground& ground, const ProjectionOptions& options, const ObjectModel& model,
                          const std::string& record) {
  const RigidTransform& pose = frame.T_world_camera;
  FitNoise noise;
  const double across = edge_noise(box.width(), options), down = edge_noise(box.height(), options);
  noise.edge_px = {across, down, across, down};
  const double margin = options.edge_margin_px;
  const std::array<bool, 4> cut{box.xmin < margin, box.ymin < margin,
                                static_cast<double>(camera.width_px) - box.xmax < margin,
                                static_cast<double>(camera.height_px) - box.ymax < margin};
  for (std::size_t i = 0; i < cut.size(); ++i)
    if (cut.at(i)) noise.edge_px.at(i) = std::numeric_limits<double>::infinity();
  if (std::count(cut.begin(), cut.end(), true) > 1)
    return base::Reject{record, "cut_by_border", "more than one edge of the box lies at the image border"};

  const auto start = start_of(box, camera, pose, ground, model, options, record);
  if (const auto* reject = std::get_if<base::Reject>(&start)) return *reject;
  const auto& from = std::get<UprightBody>(start);
  const bool on_terrain = ground.known(from.foot.x(), from.foot.y());
  const Noise of_pose = pose_noise(frame, options);
  noise.position_xy_m = of_pose.xy_m;
  noise.position_z_m = of_pose.z_m;
  noise.rotation = of_pose.rotation;
  noise.ground_m = on_terrain ? options.terrain_noise_m : options.plane_noise_m;
  const auto fit = fit_body(box, camera, pose, ground, model, noise, options.slope_base_m, from);
  if (!fit || !fit->body.foot.allFinite() || !fit->covariance.allFinite())
    return base::Reject{record, "no_fit", "no upright body on the ground fills the box"};

  Projected result;
  result.position = fit->body.foot;
  result.width_m = fit->body.width_m;
  result.height_m = fit->body.height_m;
  result.sigma_width_m = result.width_m * std::sqrt(std::max(0.0, fit->covariance(2, 2)));
  result.sigma_height_m = result.height_m * std::sqrt(std::max(0.0, fit->covariance(3, 3)));
  const double shape = options.shape_noise * result.width_m;
  result.covariance = fit->covariance.topLeftCorner<2, 2>() + shape * shape * Mat2::Identity();
  result.vehicle = model.vehicle;
  result.on_terrain = on_terrain;
  const double range = (result.position - pose.translation).norm();
  if (!(range <= options.max_range_m)) return too_far(record, range, options.max_range_m);
  const double sigma = std::sqrt(std::max(result.covariance(0, 0), result.covariance(1, 1)));
  if (!(sigma <= options.max_sigma_position_m) || !std::isfinite(result.sigma_width_m + result.sigma_height_m))
    return base::Reject{record, "uncertain",
                        "its position is known to " + base::to_fixed(sigma, 1) + " m; at most " +
                            base::to_fixed(options.max_sigma_position_m, 1) + " m"};
  return result;
}

}  // namespace

void ProjectionOptions::visit(base::OptionVisitor& v) {
  v.choice("mode", mode, {"paper", "robust"}, "paper: equations 1 to 3 on a level plane; robust: on the terrain");
  v.real("ground-up-m", ground_up_m, -1e9, 1e5,
         "local up of the plane where no terrain is known; -1e9 = from the survey");
  v.real("min-depression-deg", min_depression_deg, 0.0, 89.0, "flattest line of sight (robust)");
  v.real("max-range-m", max_range_m, 0.1, 1e5, "longest line of sight");
  v.real("ray-step-m", ray_step_m, 0.001, 100.0, "least step of the march over the terrain");
  v.real("footprint-gsd-m", footprint_gsd_m, 0.0, 100.0, "coarser ground is not in a packet's footprint");
  v.real("cut-margin-px", edge_margin_px, 0.0, 1e4, "box edges nearer to the image border are not used");
  v.real("box-noise-px", box_noise_px, 0.01, 1e3, "1 sigma of a box edge");
  v.real("box-noise-fraction", box_noise_fraction, 0.0, 1.0, "the same as a fraction of the box's side");
  v.real("pose-noise-xy-m", pose_noise_xy_m, 0.0, 100.0, "1 sigma of a camera position, where frames say nothing");
  v.real("pose-noise-z-m", pose_noise_z_m, 0.0, 100.0, "the same, height");
  v.real("pose-noise-rot-deg", pose_noise_rot_deg, 0.0, 45.0, "the same, rotation");
  v.real("terrain-noise-m", terrain_noise_m, 0.0, 100.0, "1 sigma of the terrain's height");
  v.real("plane-noise-m", plane_noise_m, 0.0, 100.0, "1 sigma of the plane's height");
  v.real("shape-noise", shape_noise, 0.0, 1.0, "1 sigma of a position as a fraction of the width");
  v.real("slope-base-m", slope_base_m, 0.01, 100.0, "length over which the terrain's slope is taken");
  v.real("max-sigma-position-m", max_sigma_position_m, 0.01, 1e4, "positions less certain are rejected");
}

Projection project_box(const PixelBox& box, const survey::Frame& frame, const survey::Camera& camera,
                       const GroundHeight& ground, const ProjectionOptions& options, const ObjectModel& model,
                       const std::string& record) {
  if (!std::isfinite(box.xmin + box.ymin + box.xmax + box.ymax) || !(box.width() > 0.0) || !(box.height() > 0.0))
    return base::Reject{record, "bad_box", "its edges are not finite, or its maximum is not above its minimum"};
  if (!frame.T_world_camera.rotation.allFinite() || !frame.T_world_camera.translation.allFinite())
    return base::Reject{record, "bad_pose", "the pose of its frame is not finite"};
  if (options.mode == "paper") return project_paper(box, frame, camera, options, model, record);
  return project_robust(box, frame, camera, {ground, options.ground_up_m}, options, model, record);
}

}  // namespace cairn::ground
