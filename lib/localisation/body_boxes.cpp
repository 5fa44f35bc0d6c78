#include "localisation/body_work.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/angle.hpp"

namespace cairn::localisation {
namespace {

using geometry::Mat2;
using geometry::Mat3;
using geometry::PixelBox;
using geometry::Vec2;
using geometry::Vec3;

// Rotation of the camera by w moves the point by w x (point - camera).
Mat2 pose_covariance(const View& view, const Vec3& at, double sigma_xy, double sigma_z, double sigma_rot) {
  const auto j = view.jacobian(view.to_camera(at));
  const Vec3 variance(sigma_xy * sigma_xy, sigma_xy * sigma_xy, sigma_z * sigma_z);
  const Vec3 arm = at - view.T_world_camera.translation;
  Mat3 cross;
  cross << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
  const Eigen::Matrix<double, 2, 3> turn = j * cross;
  return j * variance.asDiagonal() * j.transpose() + sigma_rot * sigma_rot * turn * turn.transpose();
}

// The line of the ideal image that a side is nearest its middle, where the body touches it.
std::optional<PixelBox> ideal_sides(const survey::Camera& camera, const PixelBox& b) {
  if (camera.model == survey::CameraModel::pinhole) return b;
  const Vec2 c = b.centre();
  const auto left = undistorted(camera, Vec2(b.xmin, c.y())), right = undistorted(camera, Vec2(b.xmax, c.y()));
  const auto top = undistorted(camera, Vec2(c.x(), b.ymin)), bottom = undistorted(camera, Vec2(c.x(), b.ymax));
  if (!left || !right || !top || !bottom) return std::nullopt;
  return PixelBox{left->x(), top->y(), right->x(), bottom->y()};
}

std::optional<SeenBox> see(const survey::Survey& survey, const survey::Detection& d, const Vec3& centre,
                           const BodyFitOptions& options) {
  const auto* frame = survey.frame(d.frame);
  const auto* camera = frame != nullptr ? survey.camera(frame->camera) : nullptr;
  const auto finite = [](const PixelBox& b) {
    return std::isfinite(b.xmin) && std::isfinite(b.ymin) && std::isfinite(b.xmax) && std::isfinite(b.ymax);
  };
  if (camera == nullptr || !finite(d.box) || !(d.box.width() > 0.0 && d.box.height() > 0.0)) return std::nullopt;
  if (!frame->T_world_camera.rotation.allFinite() || !frame->T_world_camera.translation.allFinite())
    return std::nullopt;
  const auto ideal = ideal_sides(*camera, d.box);
  if (!ideal || !finite(*ideal) || !(ideal->width() > 0.0 && ideal->height() > 0.0)) return std::nullopt;

  const View view = ideal_view(*camera, frame->T_world_camera);
  const double depth = view.to_camera(centre).z();
  if (!(depth > 0.0)) return std::nullopt;
  SeenBox box;
  box.time_ns = frame->time_ns;
  box.frame = frame->id;
  box.planes = box_planes(view, *ideal, centre);
  const double margin = options.edge_margin_px;
  box.planes.used = {d.box.xmin >= margin, d.box.ymin >= margin,
                     d.box.xmax <= static_cast<double>(camera->width_px) - margin,
                     d.box.ymax <= static_cast<double>(camera->height_px) - margin};
  const auto used = std::count(box.planes.used.begin(), box.planes.used.end(), true);
  if (used == 0) return std::nullopt;
  box.whole = used == 4;
  const double side = 0.5 * (ideal->width() + ideal->height());
  box.side_variance = options.sigma_px * options.sigma_px + options.sigma_size * options.sigma_size * side * side;
  const auto known = [](double sigma) { return std::isfinite(sigma) && sigma > 0.0 ? sigma : 0.0; };
  const double sigma_rot =
      base::deg_to_rad(options.pose_sigma_deg >= 0.0 ? options.pose_sigma_deg : known(frame->sigma_rot_deg));
  box.pose =
      pose_covariance(view, centre, options.pose_sigma_m >= 0.0 ? options.pose_sigma_m : known(frame->sigma_xy_m),
                      options.pose_sigma_m >= 0.0 ? options.pose_sigma_m : known(frame->sigma_z_m), sigma_rot);
  box.turn_m = sigma_rot * depth;
  box.depth_m = depth;
  box.reach_m = 0.25 * depth * (ideal->width() / view.fx_px + ideal->height() / view.fy_px);
  return box;
}

double largest_parallax(const std::vector<SeenBox>& boxes) {
  double largest = 0.0;
  for (const auto& a : boxes)
    for (const auto& b : boxes)
      largest = std::max(
          largest, std::atan2(a.planes.camera.cross(b.planes.camera).norm(), a.planes.camera.dot(b.planes.camera)));
  return largest;
}

// Video gives a target thousands of boxes that say the same: the cost is bounded.
void thin_out(std::vector<SeenBox>& boxes, std::size_t most) {
  if (boxes.size() <= most) return;
  std::vector<SeenBox> kept;
  kept.reserve(most);
  for (std::size_t i = 0; i < most; ++i) kept.push_back(boxes[i * boxes.size() / most]);
  boxes = std::move(kept);
}

}  // namespace

BodyWork prepare_body(const survey::Target& target, std::size_t index, const survey::Survey& survey,
                      const BodyFitOptions& options) {
  BodyWork work;
  work.target = index;
  std::vector<double> reach;
  for (const auto id : target.detections) {
    const auto* d = survey.detection(id);
    if (d == nullptr) continue;
    if (auto box = see(survey, *d, target.centre, options)) {
      if (box->whole) reach.push_back(box->reach_m);
      work.boxes.push_back(std::move(*box));
    }
  }
  std::stable_sort(work.boxes.begin(), work.boxes.end(), [](const SeenBox& a, const SeenBox& b) {
    return a.time_ns != b.time_ns ? a.time_ns < b.time_ns : a.frame < b.frame;
  });
  thin_out(work.boxes, static_cast<std::size_t>(options.max_boxes));
  if (work.boxes.size() < static_cast<std::size_t>(options.min_boxes) || reach.size() < 2) {
    work.reason = "fit_too_few_boxes";
    return work;
  }
  if (largest_parallax(work.boxes) < base::deg_to_rad(options.min_parallax_deg)) {
    work.reason = "fit_one_direction";
    return work;
  }
  std::nth_element(reach.begin(), reach.begin() + static_cast<std::ptrdiff_t>(reach.size() / 2), reach.end());
  const double radius = reach[reach.size() / 2];
  work.start.ellipsoid[kLogRadius] = work.start.ellipsoid[kLogHalfHeight] = std::log(radius);
  // A stray box from a camera that would stand in the body itself, or have it beside its image plane.
  std::erase_if(work.boxes, [radius](const SeenBox& box) { return box.depth_m < radius; });
  return work;
}

BoxPlanes box_planes(const View& view, const PixelBox& ideal, const Vec3& origin) {
  BoxPlanes planes;
  const Mat3& r = view.T_world_camera.rotation;
  planes.camera = view.T_world_camera.translation - origin;
  planes.forward = r.col(2);
  planes.normal = {
      r * Vec3(view.fx_px, 0.0, view.cx_px - ideal.xmin), r * Vec3(0.0, view.fy_px, view.cy_px - ideal.ymin),
      r * Vec3(view.fx_px, 0.0, view.cx_px - ideal.xmax), r * Vec3(0.0, view.fy_px, view.cy_px - ideal.ymax)};
  planes.used.fill(true);
  return planes;
}

}  // namespace cairn::localisation
