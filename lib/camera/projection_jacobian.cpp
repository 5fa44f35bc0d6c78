#include "camera/projection_jacobian.hpp"

#include <cmath>

namespace cairn::camera {
namespace {

using geometry::Mat2;
using geometry::Vec2;
using geometry::Vec3;
using survey::Camera;
using survey::CameraModel;

int radial_terms(CameraModel model) {
  switch (model) {
    case CameraModel::pinhole: return 0;
    case CameraModel::radial: return 2;
    case CameraModel::brown: return 3;
    case CameraModel::fisheye: return 4;
  }
  return 0;
}

// Pointers to the parameters of a set, in its order; f stands for fx.
template <typename AnyCamera, typename Take>
void for_each_parameter(AnyCamera& camera, IntrinsicsSet set, Take&& take) {
  if (set == IntrinsicsSet::none) return;
  if (set != IntrinsicsSet::distortion) take(camera.fx_px);
  if (set == IntrinsicsSet::all) {
    take(camera.cx_px);
    take(camera.cy_px);
  }
  if (set == IntrinsicsSet::focal) return;
  const int terms = radial_terms(camera.model);
  if (terms > 0) take(camera.k1);
  if (terms > 1) take(camera.k2);
  if (terms > 2) take(camera.k3);
  if (terms > 3) take(camera.k4);
  if (set == IntrinsicsSet::all && camera.model == CameraModel::brown) {
    take(camera.p1);
    take(camera.p2);
  }
}

// Distorted coordinates d of the point, their derivative by the point, and by k1..k4, p1, p2.
struct Distorted {
  Vec2 d;
  PointJacobian by_point;
  Eigen::Matrix<double, 2, 4> by_radial;
  Mat2 by_tangential;
};

void perspective(const Camera& c, const Vec3& p, bool terms, Distorted& out) {
  const double w = 1.0 / p.z(), x = p.x() * w, y = p.y() * w;
  if (c.model == CameraModel::pinhole) {
    out.d = {x, y};
    out.by_point << w, 0.0, -x * w, 0.0, w, -y * w;
    return;
  }
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (c.k1 + r2 * (c.k2 + r2 * c.k3));
  const double slope = 2.0 * (c.k1 + r2 * (2.0 * c.k2 + 3.0 * c.k3 * r2));  // d radial / d x = slope x
  out.d = {x * radial + 2.0 * c.p1 * x * y + c.p2 * (r2 + 2.0 * x * x),
           y * radial + c.p1 * (r2 + 2.0 * y * y) + 2.0 * c.p2 * x * y};
  const double xx = radial + x * x * slope + 2.0 * c.p1 * y + 6.0 * c.p2 * x;
  const double xy = x * y * slope + 2.0 * c.p1 * x + 2.0 * c.p2 * y;
  const double yy = radial + y * y * slope + 6.0 * c.p1 * y + 2.0 * c.p2 * x;
  out.by_point << xx * w, xy * w, -(xx * x + xy * y) * w, xy * w, yy * w, -(xy * x + yy * y) * w;
  if (!terms) return;
  const double r4 = r2 * r2, r6 = r4 * r2;
  out.by_radial << x * r2, x * r4, x * r6, 0.0, y * r2, y * r4, y * r6, 0.0;
  out.by_tangential << 2.0 * x * y, r2 + 2.0 * x * x, r2 + 2.0 * y * y, 2.0 * x * y;
}

void equidistant(const Camera& c, const Vec3& p, Distorted& out) {
  const double rho2 = p.x() * p.x() + p.y() * p.y(), rho = std::sqrt(rho2), range2 = rho2 + p.z() * p.z();
  const double theta = std::atan2(rho, p.z()), t2 = theta * theta;
  const double bent = theta * (1.0 + t2 * (c.k1 + t2 * (c.k2 + t2 * (c.k3 + t2 * c.k4))));
  const double slope = 1.0 + t2 * (3.0 * c.k1 + t2 * (5.0 * c.k2 + t2 * (7.0 * c.k3 + t2 * 9.0 * c.k4)));
  constexpr double kOnAxis = 1e-12;  // of rho / z: there theta / rho = 1 / z to the last digit
  const bool axis = rho <= kOnAxis * p.z();
  const double s = axis ? 1.0 / p.z() : bent / rho;  // d = s (X, Y)
  const double cx = axis ? 1.0 : p.x() / rho, cy = axis ? 0.0 : p.y() / rho;
  out.d = {s * p.x(), s * p.y()};
  // d bent / d rho = slope z / range2; d bent / d z = -slope rho / range2.
  const double along = slope * p.z() / range2;
  out.by_point << along * cx * cx + s * cy * cy, (along - s) * cx * cy, -slope * rho * cx / range2,
      (along - s) * cx * cy, along * cy * cy + s * cx * cx, -slope * rho * cy / range2;
  double power = theta;
  for (int i = 0; i < 4; ++i) {
    power *= t2;
    out.by_radial.col(i) = Vec2(cx, cy) * power;
  }
}

}  // namespace

int intrinsics_count(CameraModel model, IntrinsicsSet set) {
  int count = 0;
  Camera camera;
  camera.model = model;
  for_each_parameter(camera, set, [&](double&) { ++count; });
  return count;
}

std::vector<double> intrinsics_of(const Camera& camera, IntrinsicsSet set) {
  std::vector<double> values;
  for_each_parameter(camera, set, [&](const double& value) { values.push_back(value); });
  return values;
}

Camera with_intrinsics(Camera camera, IntrinsicsSet set, std::span<const double> values) {
  const double ratio = camera.fy_px / camera.fx_px;
  std::size_t next = 0;
  for_each_parameter(camera, set, [&](double& value) { value = values[next++]; });
  if (set != IntrinsicsSet::none) camera.fy_px = camera.fx_px * ratio;
  return camera;
}

bool project_with_jacobian(const Camera& camera, const Vec3& p, IntrinsicsSet set, Vec2& pixel, PointJacobian& by_point,
                           IntrinsicsJacobian* by_intrinsics) {
  constexpr double kNearest = 1e-9;  // m
  if (!(p.z() > kNearest)) return false;
  Distorted at;
  const bool terms = by_intrinsics != nullptr && set != IntrinsicsSet::none && set != IntrinsicsSet::focal;
  if (camera.model == CameraModel::fisheye) equidistant(camera, p, at);
  else perspective(camera, p, terms, at);
  const Vec2 focal(camera.fx_px, camera.fy_px);
  pixel = {focal.x() * at.d.x() + camera.cx_px, focal.y() * at.d.y() + camera.cy_px};
  by_point.row(0) = focal.x() * at.by_point.row(0);
  by_point.row(1) = focal.y() * at.by_point.row(1);
  if (by_intrinsics == nullptr || set == IntrinsicsSet::none) return true;
  int column = 0;
  if (set != IntrinsicsSet::distortion) by_intrinsics->col(column++) = Vec2(at.d.x(), at.d.y() * focal.y() / focal.x());
  if (set == IntrinsicsSet::all) {
    by_intrinsics->col(column++) = Vec2(1.0, 0.0);
    by_intrinsics->col(column++) = Vec2(0.0, 1.0);
  }
  if (set == IntrinsicsSet::focal) return true;
  const int count = radial_terms(camera.model);
  for (int i = 0; i < count; ++i) by_intrinsics->col(column++) = focal.cwiseProduct(at.by_radial.col(i));
  if (set == IntrinsicsSet::all && camera.model == CameraModel::brown)
    for (int i = 0; i < 2; ++i) by_intrinsics->col(column++) = focal.cwiseProduct(at.by_tangential.col(i));
  return true;
}

}  // namespace cairn::camera
