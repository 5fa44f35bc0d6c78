#include "camera/projection.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/angle.hpp"

namespace cairn::camera {
namespace {

using geometry::Mat2;
using geometry::Vec2;
using geometry::Vec3;
using survey::Camera;
using survey::CameraModel;

constexpr int kNewtonSteps = 30;
constexpr double kNewtonTolerance = 1e-13;  // normalised image units: 1e-13 rad, far below the 1e-9 promised

// Distorted normalised coordinates of undistorted ones, with the Jacobian.
Vec2 distort(const Camera& c, const Vec2& u, Mat2* jacobian) {
  const double x = u.x(), y = u.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double slope = c.k1 + r2 * (2.0 * c.k2 + 3.0 * c.k3 * r2);  // d radial / d r2
  if (jacobian != nullptr) {
    *jacobian << radial + 2.0 * x * x * slope + 2.0 * c.p1 * y + 6.0 * c.p2 * x,
        2.0 * x * y * slope + 2.0 * c.p1 * x + 2.0 * c.p2 * y, 2.0 * x * y * slope + 2.0 * c.p1 * x + 2.0 * c.p2 * y,
        radial + 2.0 * y * y * slope + 6.0 * c.p1 * y + 2.0 * c.p2 * x;
  }
  return {x * radial + 2.0 * c.p1 * x * y + c.p2 * (r2 + 2.0 * x * x),
          y * radial + c.p1 * (r2 + 2.0 * y * y) + 2.0 * c.p2 * x * y};
}

// d(r radial(r))/dr > 0: beyond the fold the polynomial maps wide rays back into the image.
bool radially_monotone(const Camera& c, double r2) {
  return 1.0 + r2 * (3.0 * c.k1 + r2 * (5.0 * c.k2 + r2 * 7.0 * c.k3)) > 0.0;
}

double fisheye_radius(const Camera& c, double theta) {
  const double t2 = theta * theta;
  return theta * (1.0 + t2 * (c.k1 + t2 * (c.k2 + t2 * (c.k3 + t2 * c.k4))));
}

double fisheye_slope(const Camera& c, double theta) {
  const double t2 = theta * theta;
  return 1.0 + t2 * (3.0 * c.k1 + t2 * (5.0 * c.k2 + t2 * (7.0 * c.k3 + t2 * 9.0 * c.k4)));
}

// The fold is checked along the whole way out, as a polynomial can dip and rise again.
bool monotone_up_to(const Camera& c, double r2) {
  if (c.k1 >= 0.0 && c.k2 >= 0.0 && c.k3 >= 0.0) return true;
  constexpr int kSamples = 16;
  for (int i = 1; i <= kSamples; ++i)
    if (!radially_monotone(c, r2 * i / kSamples)) return false;
  return true;
}

Vec2 to_pixel(const Camera& c, const Vec2& d) {
  return {c.fx_px * d.x() + c.cx_px, c.fy_px * d.y() + c.cy_px};
}

std::optional<Vec3> unproject_fisheye(const Camera& c, const Vec2& d) {
  const double radius = d.norm();
  double theta = radius;
  for (int i = 0; i < kNewtonSteps; ++i) {
    const double slope = fisheye_slope(c, theta);
    if (!(slope > 0.0)) return std::nullopt;
    const double step = (fisheye_radius(c, theta) - radius) / slope;
    theta -= step;
    if (std::abs(step) < kNewtonTolerance) break;
  }
  if (!(theta >= 0.0 && theta < std::numbers::pi) || std::abs(fisheye_radius(c, theta) - radius) > 1e-9)
    return std::nullopt;
  if (radius < 1e-15) return Vec3::UnitZ();
  const double s = std::sin(theta) / radius;
  return Vec3(d.x() * s, d.y() * s, std::cos(theta));
}

}  // namespace

std::optional<Vec2> project(const Camera& camera, const Vec3& p) {
  if (camera.model == CameraModel::fisheye) {
    const double rho = std::hypot(p.x(), p.y());
    const double theta = std::atan2(rho, p.z());
    if (!(p.z() > 0.0) || !(fisheye_slope(camera, theta) > 0.0)) return std::nullopt;
    const double scale = rho > 0.0 ? fisheye_radius(camera, theta) / rho : 0.0;
    return to_pixel(camera, {p.x() * scale, p.y() * scale});
  }
  if (!(p.z() > 0.0)) return std::nullopt;
  const Vec2 u(p.x() / p.z(), p.y() / p.z());
  if (camera.model == CameraModel::pinhole) return to_pixel(camera, u);
  if (!monotone_up_to(camera, u.squaredNorm())) return std::nullopt;
  return to_pixel(camera, distort(camera, u, nullptr));
}

std::optional<Vec3> unproject(const Camera& camera, const Vec2& pixel) {
  const Vec2 d((pixel.x() - camera.cx_px) / camera.fx_px, (pixel.y() - camera.cy_px) / camera.fy_px);
  if (camera.model == CameraModel::fisheye) return unproject_fisheye(camera, d);
  Vec2 u = d;
  if (camera.model != CameraModel::pinhole) {
    for (int i = 0; i < kNewtonSteps; ++i) {
      Mat2 jacobian;
      const Vec2 residual = distort(camera, u, &jacobian) - d;
      const double det = jacobian(0, 0) * jacobian(1, 1) - jacobian(0, 1) * jacobian(1, 0);
      if (!(det > 0.0)) return std::nullopt;
      const Vec2 step((jacobian(1, 1) * residual.x() - jacobian(0, 1) * residual.y()) / det,
                      (jacobian(0, 0) * residual.y() - jacobian(1, 0) * residual.x()) / det);
      u -= step;
      if (step.cwiseAbs().maxCoeff() < kNewtonTolerance) break;
    }
    constexpr double kAccepted = 1e-10;  // the header promises 1e-9 rad
    if (!((distort(camera, u, nullptr) - d).norm() < kAccepted) || !monotone_up_to(camera, u.squaredNorm()))
      return std::nullopt;
  }
  return Vec3(u.x(), u.y(), 1.0).normalized();
}

std::optional<Vec2> project_world(const Camera& camera, const geometry::RigidTransform& T_world_camera,
                                  const Vec3& p_world) {
  return project(camera, T_world_camera.rotation.transpose() * (p_world - T_world_camera.translation));
}

std::optional<geometry::Ray> pixel_ray(const Camera& camera, const geometry::RigidTransform& T_world_camera,
                                       const Vec2& pixel) {
  const auto dir_camera = unproject(camera, pixel);
  if (!dir_camera) return std::nullopt;
  return geometry::Ray{T_world_camera.translation, T_world_camera.rotation * *dir_camera};
}

bool inside_image(const Camera& camera, const Vec2& pixel, double margin) {
  const auto width = static_cast<double>(camera.width_px), height = static_cast<double>(camera.height_px);
  return pixel.x() >= margin * width && pixel.x() <= (1.0 - margin) * width && pixel.y() >= margin * height &&
         pixel.y() <= (1.0 - margin) * height;
}

Camera scaled(const Camera& camera, double factor) {
  Camera result = camera;
  result.width_px = std::llround(static_cast<double>(camera.width_px) * factor);
  result.height_px = std::llround(static_cast<double>(camera.height_px) * factor);
  result.fx_px *= factor;
  result.fy_px *= factor;
  result.cx_px *= factor;
  result.cy_px *= factor;
  return result;
}

geometry::Ring footprint(const Camera& camera, const geometry::RigidTransform& T_world_camera, double up, int per_side,
                         double max_range) {
  const auto width = static_cast<double>(camera.width_px), height = static_cast<double>(camera.height_px);
  const std::pair<Vec2, Vec2> sides[] = {
      {{0, 0}, {width, 0}}, {{width, 0}, {width, height}}, {{width, height}, {0, height}}, {{0, height}, {0, 0}}};
  geometry::Ring ring;
  bool any = false;
  for (const auto& [from, to] : sides)
    for (int i = 0; i < per_side; ++i) {
      const auto ray = pixel_ray(camera, T_world_camera, from + (to - from) * (static_cast<double>(i) / per_side));
      if (!ray) continue;
      const double drop = up - ray->origin.z();
      const double range = drop / ray->direction.z();
      const bool meets = std::isfinite(range) && range > 0.0 && range <= max_range;
      any = any || meets;
      const Vec3 p = ray->origin + ray->direction * (meets ? range : max_range);
      ring.emplace_back(p.x(), p.y());
    }
  if (!any) return {};
  if (geometry::signed_area(ring) < 0.0) std::reverse(ring.begin(), ring.end());
  return ring;
}

}  // namespace cairn::camera
