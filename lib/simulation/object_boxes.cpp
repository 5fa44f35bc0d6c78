#include "simulation/object_boxes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/random.hpp"
#include "camera/projection.hpp"

namespace cairn::simulation {
namespace {

using geometry::Mat3;
using geometry::PixelBox;
using geometry::RigidTransform;
using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

constexpr std::size_t kDirections = 642;
constexpr std::size_t kSamples = 96;
constexpr double kNear = 0.05;  // m: nothing nearer is imaged

// Spread evenly over the sphere (golden spiral).
Vec3 direction(std::size_t i, std::size_t count) {
  const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
  const double angle = static_cast<double>(i) * std::numbers::pi * (3.0 - std::sqrt(5.0));
  const double r = std::sqrt(std::max(0.0, 1.0 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

std::vector<Vec3> extreme_vertices(const std::vector<Vec3>& vertices) {
  if (vertices.size() <= kDirections) return vertices;
  std::vector<std::uint8_t> kept(vertices.size(), 0);
  for (std::size_t i = 0; i < kDirections; ++i) {
    const Vec3 d = direction(i, kDirections);
    std::size_t best = 0;
    double reach = -std::numeric_limits<double>::infinity();
    for (std::size_t v = 0; v < vertices.size(); ++v)
      if (const double along = d.dot(vertices[v]); along > reach) {
        reach = along;
        best = v;
      }
    kept[best] = 1;
  }
  std::vector<Vec3> result;
  for (std::size_t v = 0; v < vertices.size(); ++v)
    if (kept[v] != 0) result.push_back(vertices[v]);
  return result;
}

struct Bounds {
  PixelBox box{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
               -std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  void extend(const Vec2& p) {
    box.xmin = std::min(box.xmin, p.x());
    box.ymin = std::min(box.ymin, p.y());
    box.xmax = std::max(box.xmax, p.x());
    box.ymax = std::max(box.ymax, p.y());
  }
  [[nodiscard]] bool empty() const { return !(box.xmax > box.xmin && box.ymax > box.ymin); }
};

// Keeps the part of a polygon where signed_distance >= 0.
template <typename Point, typename Distance>
std::vector<Point> half(const std::vector<Point>& polygon, Distance&& signed_distance) {
  std::vector<Point> result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    const double da = signed_distance(a), db = signed_distance(b);
    if (da >= 0.0) result.push_back(a);
    if ((da > 0.0 && db < 0.0) || (da < 0.0 && db > 0.0)) result.push_back(a + da / (da - db) * (b - a));
  }
  return result;
}

}  // namespace

ObjectOutline::ObjectOutline(const TriangleMesh& exposed)
    : mesh_(exposed), extreme_(extreme_vertices(exposed.vertices)) {
  centre_ = exposed.bounds().centre();
  for (const Vec3& v : extreme_) radius_ = std::max(radius_, (v - centre_).norm());
  // Stratified along the running sum of areas.
  std::vector<double> sum(mesh_.triangles.size() + 1, 0.0);
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) sum[t + 1] = sum[t] + mesh_.area_vector(t).norm();
  base::Random random(0, "simulation samples", mesh_.triangles.size());
  for (std::size_t i = 0; i < kSamples && sum.back() > 0.0; ++i) {
    // Each third of the samples covers the whole surface.
    const std::size_t stratum = i % (kSamples / 3) * 3 + i / (kSamples / 3);
    const double at = (static_cast<double>(stratum) + random.uniform()) / static_cast<double>(kSamples) * sum.back();
    const auto t = static_cast<std::size_t>(std::upper_bound(sum.begin() + 1, sum.end() - 1, at) - sum.begin()) - 1;
    double a = random.uniform(), b = random.uniform();
    if (a + b > 1.0) {
      a = 1.0 - a;
      b = 1.0 - b;
    }
    const auto& [i0, i1, i2] = mesh_.triangles[t];
    const Vec3 &p = mesh_.vertices[i0], &q = mesh_.vertices[i1], &r = mesh_.vertices[i2];
    samples_.push_back({p + a * (q - p) + b * (r - p), mesh_.area_vector(t).normalized()});
  }
}

std::optional<Outline> ObjectOutline::seen(const survey::Camera& camera, const RigidTransform& T_world_camera) const {
  const Mat3 R_camera_world = T_world_camera.rotation.transpose();
  const Vec3 centre = R_camera_world * (centre_ - T_world_camera.translation);
  if (centre.z() < -radius_) return std::nullopt;
  if (centre.z() < radius_ + kNear) return clipped(camera, T_world_camera);
  const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
  const bool pinhole = camera.model == survey::CameraModel::pinhole;
  if (pinhole) {
    // The bounding sphere lies beyond one of the planes through the camera and a side of the image.
    const auto outside = [&](double at, double size, double f, double middle) {
      const double low = -middle / f, high = (size - middle) / f;
      return at - low * centre.z() < -radius_ * std::hypot(1.0, low) ||
             high * centre.z() - at < -radius_ * std::hypot(1.0, high);
    };
    if (outside(centre.x(), w, camera.fx_px, camera.cx_px) || outside(centre.y(), h, camera.fy_px, camera.cy_px))
      return std::nullopt;
  }
  Bounds bounds;
  for (const Vec3& v : extreme_) {
    const Vec3 p = R_camera_world * (v - T_world_camera.translation);
    if (pinhole) {
      bounds.extend({camera.fx_px * p.x() / p.z() + camera.cx_px, camera.fy_px * p.y() / p.z() + camera.cy_px});
      continue;
    }
    const auto pixel = camera::project(camera, p);
    if (!pixel) return clipped(camera, T_world_camera);
    bounds.extend(*pixel);
  }
  const PixelBox& box = bounds.box;
  if (bounds.empty() || box.xmax <= 0.0 || box.ymax <= 0.0 || box.xmin >= w || box.ymin >= h) return std::nullopt;
  if (box.xmin >= 0.0 && box.ymin >= 0.0 && box.xmax <= w && box.ymax <= h) return Outline{box, true, 1.0};
  auto result = clipped(camera, T_world_camera);
  if (result) result->inside_share = std::min(1.0, result->box.area() / box.area());
  return result;
}

std::optional<Outline> ObjectOutline::clipped(const survey::Camera& camera,
                                              const RigidTransform& T_world_camera) const {
  const auto w = static_cast<double>(camera.width_px), h = static_cast<double>(camera.height_px);
  const auto in_camera = [&](std::uint32_t v) {
    return Vec3(T_world_camera.rotation.transpose() * (mesh_.vertices[v] - T_world_camera.translation));
  };
  Bounds inside, all;
  bool cut = false;
  // Sides of the image that a vertex lies beyond; kBehind = it has no pixel.
  constexpr std::uint8_t kBehind = 16;
  std::vector<Vec2> pixels(mesh_.vertices.size());
  std::vector<std::uint8_t> beyond(mesh_.vertices.size());
  for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
    const Vec3 p = in_camera(v);
    const auto pixel = p.z() < kNear ? std::nullopt : camera::project(camera, p);
    if (!pixel) {
      beyond[v] = kBehind;
      cut = true;
      continue;
    }
    pixels[v] = *pixel;
    all.extend(*pixel);
    beyond[v] = static_cast<std::uint8_t>((pixel->x() < 0.0 ? 1 : 0) | (pixel->x() > w ? 2 : 0) |
                                          (pixel->y() < 0.0 ? 4 : 0) | (pixel->y() > h ? 8 : 0));
    if (beyond[v] == 0) inside.extend(*pixel);
  }
  for (const auto& [a, b, c] : mesh_.triangles) {
    const int any = beyond[a] | beyond[b] | beyond[c];
    if (any == 0 || (beyond[a] & beyond[b] & beyond[c]) != 0) continue;
    std::vector<Vec2> outline{pixels[a], pixels[b], pixels[c]};
    if ((any & kBehind) != 0) {
      outline.clear();
      std::vector<Vec3> corners{in_camera(a), in_camera(b), in_camera(c)};
      corners = half(corners, [](const Vec3& p) { return p.z() - kNear; });
      for (const Vec3& p : corners)
        if (const auto pixel = camera::project(camera, p)) outline.push_back(*pixel);
      for (const Vec2& p : outline) all.extend(p);
    }
    outline = half(outline, [](const Vec2& p) { return p.x(); });
    outline = half(outline, [](const Vec2& p) { return p.y(); });
    outline = half(outline, [w](const Vec2& p) { return w - p.x(); });
    outline = half(outline, [h](const Vec2& p) { return h - p.y(); });
    for (const Vec2& p : outline) inside.extend(p);
  }
  if (inside.empty()) return std::nullopt;
  // Cutting an edge at the border leaves a rounding error.
  inside.box = {std::max(0.0, inside.box.xmin), std::max(0.0, inside.box.ymin), std::min(w, inside.box.xmax),
                std::min(h, inside.box.ymax)};
  const bool whole = !cut && all.box == inside.box;
  return Outline{inside.box, whole, std::min(1.0, inside.box.area() / all.box.area())};
}

Obstruction::Joined Obstruction::join(const TriangleMesh& terrain, const std::vector<PlacedObject>& objects) {
  Joined joined;
  const auto append = [&](const TriangleMesh& mesh) {
    const auto offset = static_cast<std::uint32_t>(joined.mesh.vertices.size());
    joined.mesh.vertices.insert(joined.mesh.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const auto& t : mesh.triangles) joined.mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  };
  append(terrain);
  for (const PlacedObject& object : objects) {
    joined.body_begin.push_back(static_cast<std::uint32_t>(joined.mesh.triangles.size()));
    append(object.shape.body);
    joined.body_end.push_back(static_cast<std::uint32_t>(joined.mesh.triangles.size()));
    append(object.shape.pedestal);
  }
  return joined;
}

Obstruction::Obstruction(const TriangleMesh& terrain, const std::vector<PlacedObject>& objects)
    : Obstruction(join(terrain, objects)) {}

Obstruction::Obstruction(Joined joined)
    : body_begin_(std::move(joined.body_begin)), body_end_(std::move(joined.body_end)), scene_(joined.mesh) {}

double Obstruction::visible_share(std::size_t object, const ObjectOutline& outline, const survey::Camera& camera,
                                  const RigidTransform& T_world_camera) const {
  const Vec3& from = T_world_camera.translation;
  const auto& samples = outline.samples();
  double seen = 0.0, all = 0.0;
  const auto test = [&](std::size_t first, std::size_t last) {
    std::vector<geometry::Ray> rays;
    std::vector<double> weight, distance;
    for (std::size_t i = first; i < last; ++i) {
      const Vec3 way = samples[i].point - from;
      const double length = way.norm();
      const double facing = -samples[i].normal.dot(way) / length;
      if (!(facing > 0.0)) continue;
      const auto pixel = camera::project_world(camera, T_world_camera, samples[i].point);
      if (!pixel || !camera::inside_image(camera, *pixel)) continue;
      rays.push_back({from, way / length});
      weight.push_back(facing / (length * length));
      distance.push_back(length);
    }
    const auto hits = scene_.cast(rays);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      all += weight[i];
      const bool own = hits[i].triangle >= body_begin_[object] && hits[i].triangle < body_end_[object];
      // A body sunk into the ground: the surfaces meet at the sample itself.
      constexpr double kTouch = 0.01;  // m
      if (!hits[i].hit() || own || hits[i].distance > distance[i] - kTouch) seen += weight[i];
    }
  };
  // Mostly nothing is in the way: a third of the samples tells so.
  const std::size_t third = samples.size() / 3;
  test(0, third);
  if (seen < all) test(third, samples.size());
  return all > 0.0 ? seen / all : 1.0;
}

bool Obstruction::free(const Vec3& from, const Vec3& to) const {
  const visibility::Segment segment{from, to};
  return scene_.blocked(std::span(&segment, 1), 0.01)[0] == 0;
}

}  // namespace cairn::simulation
