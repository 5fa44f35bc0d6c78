#include "simulation/render_scene.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/parallel.hpp"

namespace cairn::simulation {
namespace {

using geometry::TriangleMesh;
using geometry::Vec3;

constexpr double kSmoothEdge = 0.78;  // cosine of the sharpest edge that is shaded round: 39 deg
constexpr double kExposure = 1.35;    // grey of 0.18 in full sun becomes a mid tone
constexpr std::size_t kVertexGrain = 2048;

void require(bool holds, std::string_view what, double value, std::string_view allowed) {
  if (holds) return;
  throw base::Error(base::ErrorCode::invalid_argument, std::string(what) + " is out of range")
      .found(base::to_text(value))
      .allowed(std::string(allowed));
}

void check(const std::vector<RenderBody>& bodies, const Lighting& light) {
  for (const RenderBody& body : bodies) {
    require(body.object >= -1 && body.object <= 65533, "the object number", static_cast<double>(body.object),
            "-1 to 65533: masks have 16 bits");
    if (!body.mesh.colours.empty() && body.mesh.colours.size() != body.mesh.vertices.size())
      throw base::Error(base::ErrorCode::invalid_argument, "a mesh needs one colour a vertex, or none");
  }
  require(light.sun_elevation_deg >= 1.0 && light.sun_elevation_deg <= 90.0, "the sun's elevation",
          light.sun_elevation_deg, "1 to 90 deg");
  require(std::isfinite(light.sun_azimuth_deg), "the sun's azimuth", light.sun_azimuth_deg, "a finite number");
  require(light.openness_rays >= 0 && light.openness_rays <= 256, "the number of openness rays",
          static_cast<double>(light.openness_rays), "0 to 256");
  require(light.openness_m > 0.0 && light.haze_m > 0.0, "a length of the lighting",
          std::min(light.openness_m, light.haze_m), "above 0 m");
}

// Which triangles use each vertex.
struct Fans {
  std::vector<std::uint32_t> first, triangles;

  explicit Fans(const TriangleMesh& mesh) : first(mesh.vertices.size() + 1, 0), triangles(3 * mesh.triangles.size()) {
    for (const auto& t : mesh.triangles)
      for (const auto v : t) ++first[v + 1];
    for (std::size_t v = 1; v < first.size(); ++v) first[v] += first[v - 1];
    auto next = first;
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
      for (const auto v : mesh.triangles[i]) triangles[next[v]++] = static_cast<std::uint32_t>(i);
  }
};

using CornerNormals = std::vector<std::array<Eigen::Vector3f, 3>>;

CornerNormals corner_normals(const TriangleMesh& mesh, const Fans& fans) {
  CornerNormals normals(mesh.triangles.size());
  base::parallel_for(mesh.triangles.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 own = mesh.area_vector(i).normalized();
      for (std::size_t c = 0; c < 3; ++c) {
        const auto v = mesh.triangles[i][c];
        Vec3 sum = Vec3::Zero();
        for (auto k = fans.first[v]; k < fans.first[v + 1]; ++k) {
          const Vec3 area = mesh.area_vector(fans.triangles[k]);
          if (area.dot(own) >= kSmoothEdge * area.norm()) sum += area;
        }
        normals[i][c] = (sum.norm() > 0.0 ? Vec3(sum.normalized()) : own).cast<float>();
      }
    }
  });
  return normals;
}

// Cosine-weighted directions about +z, evenly spread (a golden-ratio spiral on the disc, lifted).
std::vector<Vec3> sky_directions(std::size_t count) {
  std::vector<Vec3> directions;
  for (std::size_t i = 0; i < count; ++i) {
    const double r = std::sqrt((static_cast<double>(i) + 0.5) / static_cast<double>(count));
    const double a = static_cast<double>(i) * std::numbers::pi * (3.0 - std::sqrt(5.0));
    directions.emplace_back(r * std::cos(a), r * std::sin(a), std::sqrt(1.0 - r * r));
  }
  return directions;
}

// Share of the directions above each vertex that nothing near blocks.
// Ground that no body stands near needs few rays: it is open, or changes slowly.
std::vector<bool> near_bodies(const TriangleMesh& mesh, const std::vector<RenderBody>& bodies,
                              const std::vector<std::uint32_t>& body_of, double reach) {
  constexpr double kCell = 1.0;  // m
  geometry::Box3 ground;
  for (const Vec3& v : mesh.vertices) ground.extend(v);
  const Vec3 size = ground.size();
  const auto columns = static_cast<std::size_t>(std::min(size.x() / kCell, 20000.0)) + 1;
  const auto rows = static_cast<std::size_t>(std::min(size.y() / kCell, 20000.0)) + 1;
  const double width = size.x() / static_cast<double>(columns) + 1e-9,
               height = size.y() / static_cast<double>(rows) + 1e-9;
  const auto column = [&](double x) {
    return static_cast<std::size_t>(std::clamp((x - ground.min.x()) / width, 0.0, static_cast<double>(columns - 1)));
  };
  const auto row = [&](double y) {
    return static_cast<std::size_t>(std::clamp((y - ground.min.y()) / height, 0.0, static_cast<double>(rows - 1)));
  };
  std::vector<bool> cells(columns * rows, false), near(mesh.vertices.size(), false);
  std::vector<geometry::Box3> boxes(bodies.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (const auto v : mesh.triangles[i]) boxes[body_of[i]].extend(mesh.vertices[v]);
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].part == SurfacePart::terrain || boxes[b].empty()) continue;
    for (std::size_t r = row(boxes[b].min.y() - reach); r <= row(boxes[b].max.y() + reach); ++r)
      for (std::size_t c = column(boxes[b].min.x() - reach); c <= column(boxes[b].max.x() + reach); ++c)
        cells[r * columns + c] = true;
  }
  for (std::size_t v = 0; v < near.size(); ++v)
    near[v] = cells[row(mesh.vertices[v].y()) * columns + column(mesh.vertices[v].x())];
  return near;
}

std::vector<float> openness(const TriangleMesh& mesh, const Fans& fans, const visibility::Scene& rays,
                            const Lighting& light, const std::vector<bool>& near) {
  std::vector<float> open(mesh.vertices.size(), 1.0F);
  const auto all = sky_directions(static_cast<std::size_t>(light.openness_rays));
  if (all.empty()) return open;
  const auto few = sky_directions(std::max<std::size_t>(4, all.size() / 4));
  base::parallel_for(mesh.vertices.size(), kVertexGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3> ends;
    std::vector<std::uint8_t> blocked;
    for (std::size_t v = begin; v < end; ++v) {
      Vec3 normal = Vec3::Zero();
      for (auto k = fans.first[v]; k < fans.first[v + 1]; ++k) normal += mesh.area_vector(fans.triangles[k]);
      if (!(normal.norm() > 0.0)) continue;
      normal.normalize();
      const Vec3 side =
          (std::abs(normal.x()) < 0.8 ? normal.cross(Vec3::UnitX()) : normal.cross(Vec3::UnitY())).normalized();
      const Vec3 other = normal.cross(side);
      const Vec3 from = mesh.vertices[v] + 0.004 * normal;
      const auto& directions = near[v] ? all : few;
      ends.resize(directions.size());
      blocked.resize(directions.size());
      for (std::size_t d = 0; d < directions.size(); ++d)
        ends[d] = from + light.openness_m *
                             (directions[d].x() * side + directions[d].y() * other + directions[d].z() * normal);
      rays.blocked_from(from, ends, blocked, 0.0);
      std::size_t free = 0;
      for (const auto b : blocked) free += b == 0 ? 1 : 0;
      open[v] = static_cast<float>(free) / static_cast<float>(directions.size());
    }
  });
  return open;
}

TriangleMesh joined(std::vector<RenderBody>& bodies, std::vector<std::uint32_t>& body_of, std::vector<bool>& coloured) {
  TriangleMesh all;
  bool any_colour = false;
  for (const auto& body : bodies) any_colour |= !body.mesh.colours.empty();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    TriangleMesh& mesh = bodies[b].mesh;
    const auto offset = static_cast<std::uint32_t>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    coloured.push_back(!mesh.colours.empty());
    if (any_colour) {
      mesh.colours.resize(mesh.vertices.size());
      all.colours.insert(all.colours.end(), mesh.colours.begin(), mesh.colours.end());
    }
    for (const auto& t : mesh.triangles) all.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    body_of.insert(body_of.end(), mesh.triangles.size(), static_cast<std::uint32_t>(b));
    mesh = TriangleMesh();
  }
  return all;
}

}  // namespace

struct RenderScene::Impl {
  std::vector<RenderBody> bodies;
  Lighting light;
  std::vector<std::uint32_t> body_of;
  std::vector<bool> coloured;
  TriangleMesh mesh;
  visibility::Scene rays;
  CornerNormals normals;
  std::vector<float> open;
  Vec3 to_sun;

  Impl(std::vector<RenderBody>&& given, const Lighting& lighting)
      : bodies(std::move(given)), light(lighting), mesh(joined(bodies, body_of, coloured)), rays(mesh) {
    const Fans fans(mesh);
    normals = corner_normals(mesh, fans);
    open = openness(mesh, fans, rays, light, near_bodies(mesh, bodies, body_of, light.openness_m));
    const double a = base::deg_to_rad(light.sun_azimuth_deg), e = base::deg_to_rad(light.sun_elevation_deg);
    to_sun = Vec3(std::cos(e) * std::sin(a), std::cos(e) * std::cos(a), std::sin(e));
  }
};

RenderScene::RenderScene(std::vector<RenderBody> bodies, const Lighting& lighting) {
  check(bodies, lighting);
  impl_ = std::make_unique<Impl>(std::move(bodies), lighting);
}
RenderScene::~RenderScene() = default;
RenderScene::RenderScene(RenderScene&&) noexcept = default;
RenderScene& RenderScene::operator=(RenderScene&&) noexcept = default;

RenderScene::SurfacePoint RenderScene::at(std::uint32_t triangle, const Vec3& position) const {
  const auto& t = impl_->mesh.triangles[triangle];
  const Vec3 &a = impl_->mesh.vertices[t[0]], &b = impl_->mesh.vertices[t[1]], &c = impl_->mesh.vertices[t[2]];
  const Vec3 n = (b - a).cross(c - a);
  const double twice = n.squaredNorm();
  SurfacePoint point;
  point.position = position;
  point.face_normal = n.normalized();
  point.body_index = impl_->body_of[triangle];
  point.body = &impl_->bodies[point.body_index];
  std::array<double, 3> w = {n.dot((c - b).cross(position - b)) / twice, n.dot((a - c).cross(position - c)) / twice,
                             0.0};
  w[0] = std::clamp(w[0], 0.0, 1.0);
  w[1] = std::clamp(w[1], 0.0, 1.0 - w[0]);
  w[2] = 1.0 - w[0] - w[1];
  Vec3 smooth = Vec3::Zero();
  point.openness = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    smooth += w[k] * impl_->normals[triangle][k].cast<double>();
    point.openness += w[k] * static_cast<double>(impl_->open[t[k]]);
  }
  point.normal = smooth.norm() > 0.0 ? Vec3(smooth.normalized()) : point.face_normal;
  point.has_colour = impl_->coloured[point.body_index];
  if (point.has_colour)
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t i = 0; i < 3; ++i)
        point.own_colour[static_cast<Eigen::Index>(i)] += w[k] * linear_from_srgb(impl_->mesh.colours[t[k]][i] / 255.0);
  return point;
}

Colour RenderScene::shade(const SurfacePoint& point, double footprint, bool sunlit) const {
  const Lighting& light = impl_->light;
  const auto look = look_at(point.body->material, point.position, point.normal, footprint,
                            point.has_colour ? &point.own_colour : nullptr);
  // The sky lights from above, the ground throws a warm third of the sun back from below.
  const double up = 0.5 * (1.0 + look.normal.z());
  const Colour bounce = 0.16 * light.sun_strength * std::max(0.0, impl_->to_sun.z()) * Colour(1.0, 0.85, 0.68);
  Colour received = point.openness * (up * light.ambient + (1.0 - up) * bounce);
  if (sunlit) received += light.sun_strength * std::max(0.0, look.normal.dot(impl_->to_sun)) * light.sun;
  return kExposure * look.albedo.cwiseProduct(received);
}

Colour RenderScene::through_air(const Colour& light, const Vec3& direction, double distance) const {
  const double clear = std::exp(-distance / impl_->light.haze_m);
  Vec3 level(direction.x(), direction.y(), 0.0);
  return clear * light + (1.0 - clear) * sky(level.norm() > 0.0 ? Vec3(level.normalized()) : direction);
}

Colour RenderScene::sky(const Vec3& direction) const {
  const double height = std::sqrt(std::clamp(direction.z(), 0.0, 1.0));
  const Colour horizon(0.72, 0.79, 0.86), zenith(0.22, 0.40, 0.72);
  const double glow = std::pow(std::max(0.0, direction.dot(impl_->to_sun)), 24.0);
  return horizon + height * (zenith - horizon) + 0.25 * glow * impl_->light.sun;
}

const TriangleMesh& RenderScene::mesh() const {
  return impl_->mesh;
}
const visibility::Scene& RenderScene::rays() const {
  return impl_->rays;
}
std::span<const RenderBody> RenderScene::bodies() const {
  return impl_->bodies;
}
std::size_t RenderScene::body_of(std::uint32_t triangle) const {
  return impl_->body_of[triangle];
}
const Lighting& RenderScene::lighting() const {
  return impl_->light;
}
const Vec3& RenderScene::to_sun() const {
  return impl_->to_sun;
}

}  // namespace cairn::simulation
