#include "localisation/view.hpp"

#include "camera/projection.hpp"

namespace cairn::localisation {

using geometry::PixelBox;
using geometry::Vec2;
using geometry::Vec3;

namespace {
constexpr double kWidestCosine = 0.17364817766693033;  // cos 80 deg
}

std::optional<Vec2> View::project(const Vec3& p_world) const {
  const Vec3 p = to_camera(p_world);
  if (!(p.z() > 0.0)) return std::nullopt;
  return Vec2(fx_px * p.x() / p.z() + cx_px, fy_px * p.y() / p.z() + cy_px);
}

Eigen::Matrix<double, 2, 3> View::jacobian(const Vec3& p) const {
  Eigen::Matrix<double, 2, 3> in_camera;
  in_camera << fx_px / p.z(), 0.0, -fx_px * p.x() / (p.z() * p.z()), 0.0, fy_px / p.z(),
      -fy_px * p.y() / (p.z() * p.z());
  return in_camera * T_world_camera.rotation.transpose();
}

Vec3 View::direction(const Vec2& pixel) const {
  return T_world_camera.rotation * Vec3((pixel.x() - cx_px) / fx_px, (pixel.y() - cy_px) / fy_px, 1.0);
}

View ideal_view(const survey::Camera& camera, const geometry::RigidTransform& T_world_camera) {
  return {T_world_camera, camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px};
}

std::optional<Vec2> undistorted(const survey::Camera& camera, const Vec2& pixel) {
  const auto direction = camera::unproject(camera, pixel);
  if (!direction || !(direction->z() > kWidestCosine)) return std::nullopt;
  return Vec2(camera.fx_px * direction->x() / direction->z() + camera.cx_px,
              camera.fy_px * direction->y() / direction->z() + camera.cy_px);
}

std::optional<PixelBox> undistorted(const survey::Camera& camera, const PixelBox& box) {
  if (camera.model == survey::CameraModel::pinhole) return box;
  constexpr double kThird = 1.0 / 3.0;
  PixelBox ideal;
  const Vec2 centre = box.centre();
  const double xs[] = {box.xmin, centre.x(), box.xmax}, ys[] = {box.ymin, centre.y(), box.ymax};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (i == 1 && j == 1) continue;
      const auto p = undistorted(camera, Vec2(xs[i], ys[j]));
      if (!p) return std::nullopt;
      if (i == 0) ideal.xmin += p->x() * kThird;
      if (i == 2) ideal.xmax += p->x() * kThird;
      if (j == 0) ideal.ymin += p->y() * kThird;
      if (j == 2) ideal.ymax += p->y() * kThird;
    }
  if (!(ideal.width() > 0.0 && ideal.height() > 0.0)) return std::nullopt;
  return ideal;
}

}  // namespace cairn::localisation
