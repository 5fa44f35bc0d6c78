#include "coverage/view_frustum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "camera/projection.hpp"

namespace cairn::coverage {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

constexpr int kBorderSamples = 32;      // a side
constexpr double kRectanglePad = 0.02;  // of the size: more than the border bulges between samples
constexpr std::size_t kTableSize = 65;  // a side
constexpr double kDifference = 1e-4;    // image units; central differences are good to its square

// Pixel density at one point by central differences of the projection.
double density(const survey::Camera& camera, double x, double y) {
  const auto at = [&camera](double u, double v) { return camera::project(camera, Vec3(u, v, 1.0)); };
  const auto left = at(x - kDifference, y), right = at(x + kDifference, y);
  const auto up = at(x, y - kDifference), down = at(x, y + kDifference);
  if (!left || !right || !up || !down) return std::numeric_limits<double>::quiet_NaN();
  const Vec2 dx = (*right - *left) / (2.0 * kDifference), dy = (*down - *up) / (2.0 * kDifference);
  return std::abs(dx.x() * dy.y() - dx.y() * dy.x()) / (camera.fx_px * camera.fy_px);
}

// The frame's border in undistorted coordinates. False where a part of it lies beyond half a turn or the
// distortion cannot be inverted.
bool bound_by_border(CameraBounds& b) {
  const auto width = static_cast<double>(b.camera.width_px), height = static_cast<double>(b.camera.height_px);
  const double left = b.margin * width, right = width - left, top = b.margin * height, bottom = height - top;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  ImageRectangle outer{kInf, -kInf, kInf, -kInf}, inner{-kInf, kInf, -kInf, kInf};
  const auto point = [&](double u, double v) -> std::optional<Vec2> {
    const auto direction = camera::unproject(b.camera, Vec2(u, v));
    if (!direction || !(direction->z() > 0.05)) return std::nullopt;
    const Vec2 p = direction->head<2>() / direction->z();
    outer.xmin = std::min(outer.xmin, p.x());
    outer.xmax = std::max(outer.xmax, p.x());
    outer.ymin = std::min(outer.ymin, p.y());
    outer.ymax = std::max(outer.ymax, p.y());
    return p;
  };
  for (int i = 0; i <= kBorderSamples; ++i) {
    const double s = static_cast<double>(i) / kBorderSamples;
    const auto l = point(left, top + s * (bottom - top)), r = point(right, top + s * (bottom - top));
    const auto t = point(left + s * (right - left), top), d = point(left + s * (right - left), bottom);
    if (!l || !r || !t || !d) return false;
    inner.xmin = std::max(inner.xmin, l->x());
    inner.xmax = std::min(inner.xmax, r->x());
    inner.ymin = std::max(inner.ymin, t->y());
    inner.ymax = std::min(inner.ymax, d->y());
  }
  const double px = kRectanglePad * (outer.xmax - outer.xmin), py = kRectanglePad * (outer.ymax - outer.ymin);
  b.outer = {outer.xmin - px, outer.xmax + px, outer.ymin - py, outer.ymax + py};
  b.inner = {inner.xmin + px, inner.xmax - px, inner.ymin + py, inner.ymax - py};
  return true;
}

void fill_table(CameraBounds& b) {
  b.table.resize(kTableSize * kTableSize);
  for (std::size_t j = 0; j < kTableSize; ++j)
    for (std::size_t i = 0; i < kTableSize; ++i) {
      const double step = 1.0 / static_cast<double>(kTableSize - 1);
      const double x = b.outer.xmin + (b.outer.xmax - b.outer.xmin) * static_cast<double>(i) * step;
      const double y = b.outer.ymin + (b.outer.ymax - b.outer.ymin) * static_cast<double>(j) * step;
      b.table[j * kTableSize + i] = density(b.camera, x, y);
    }
}

std::array<Vec3, 5> planes(const ImageRectangle& r, const Mat3& R_world_camera) {
  const std::array<Vec3, 5> camera = {Vec3(1, 0, -r.xmin), Vec3(-1, 0, r.xmax), Vec3(0, 1, -r.ymin),
                                      Vec3(0, -1, r.ymax), Vec3(0, 0, 1)};
  std::array<Vec3, 5> world;
  std::transform(camera.begin(), camera.end(), world.begin(), [&](const Vec3& n) { return Vec3(R_world_camera * n); });
  return world;
}

}  // namespace

double CameraBounds::magnification(double x, double y) const {
  if (exact) return 1.0;
  if (table.empty()) return density(camera, x, y);
  const double scale = static_cast<double>(kTableSize - 1);
  const double u = std::clamp((x - outer.xmin) / (outer.xmax - outer.xmin), 0.0, 1.0) * scale;
  const double v = std::clamp((y - outer.ymin) / (outer.ymax - outer.ymin), 0.0, 1.0) * scale;
  const auto i = std::min(static_cast<std::size_t>(u), kTableSize - 2);
  const auto j = std::min(static_cast<std::size_t>(v), kTableSize - 2);
  const double a = u - static_cast<double>(i), c = v - static_cast<double>(j);
  const double* row = table.data() + j * kTableSize + i;
  const double value =
      (1.0 - c) * ((1.0 - a) * row[0] + a * row[1]) + c * ((1.0 - a) * row[kTableSize] + a * row[kTableSize + 1]);
  return std::isfinite(value) ? value : density(camera, x, y);
}

CameraBounds camera_bounds(const survey::Camera& camera, double margin) {
  if (camera.width_px <= 0 || camera.height_px <= 0 || !(camera.fx_px > 0.0) || !(camera.fy_px > 0.0) ||
      !std::isfinite(camera.fx_px + camera.fy_px + camera.cx_px + camera.cy_px))
    throw base::Error(base::ErrorCode::invalid_input, "a camera has no size or no focal length")
        .record("camera " + std::to_string(camera.id.value))
        .allowed("width, height, fx, fy > 0");
  CameraBounds b;
  b.camera = camera;
  b.margin = margin;
  const bool distorted = camera.model == survey::CameraModel::fisheye || camera.k1 != 0.0 || camera.k2 != 0.0 ||
                         camera.k3 != 0.0 || camera.p1 != 0.0 || camera.p2 != 0.0;
  if (camera.model == survey::CameraModel::pinhole || !distorted) {
    const auto width = static_cast<double>(camera.width_px), height = static_cast<double>(camera.height_px);
    b.outer = {(margin * width - camera.cx_px) / camera.fx_px, ((1.0 - margin) * width - camera.cx_px) / camera.fx_px,
               (margin * height - camera.cy_px) / camera.fy_px,
               ((1.0 - margin) * height - camera.cy_px) / camera.fy_px};
    b.inner = b.outer;
    b.bounded = b.exact = true;
    return b;
  }
  b.bounded = bound_by_border(b);
  if (b.bounded) {
    fill_table(b);
  } else {
    b.inner = {1.0, -1.0, 1.0, -1.0};
  }
  return b;
}

ViewFrustum view_frustum(const CameraBounds& bounds, const geometry::RigidTransform& T_world_camera) {
  ViewFrustum v;
  v.bounds = &bounds;
  v.centre = T_world_camera.translation;
  v.R_camera_world = T_world_camera.rotation.transpose();
  v.outer.fill(Vec3::Zero());
  v.inner.fill(Vec3::Zero());
  if (bounds.bounded) {
    v.outer = planes(bounds.outer, T_world_camera.rotation);
    v.has_inner = bounds.inner.xmin < bounds.inner.xmax && bounds.inner.ymin < bounds.inner.ymax;
    if (v.has_inner) v.inner = planes(bounds.inner, T_world_camera.rotation);
  }
  return v;
}

bool ViewFrustum::sees(const Vec3& p_world) const {
  const Vec3 p = R_camera_world * (p_world - centre);
  if (!(p.z() > 0.0)) return false;
  if (bounds->exact) return bounds->outer.contains(p.x() / p.z(), p.y() / p.z());
  const auto pixel = camera::project(bounds->camera, p);
  return pixel && camera::inside_image(bounds->camera, *pixel, bounds->margin);
}

}  // namespace cairn::coverage
