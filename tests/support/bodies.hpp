// Analytic bodies as closed outward meshes, with their exact mass properties (fragility.md section 6).
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "geometry/mass_properties.hpp"
#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::testing {

using geometry::MassProperties;
using geometry::Mat3;
using geometry::Ring;
using geometry::Triangle;
using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

// Prism over a counter-clockwise ring that is star-shaped about its first vertex, z from 0 to height,
// its top moved by `shear` in plan.
inline TriangleMesh prism(const Ring& ring, double height, const Vec2& shear = Vec2::Zero()) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(ring.size());
  for (const auto& p : ring) mesh.vertices.emplace_back(p.x(), p.y(), 0.0);
  for (const auto& p : ring) mesh.vertices.emplace_back(p.x() + shear.x(), p.y() + shear.y(), height);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, n + j});
    mesh.triangles.push_back({i, n + j, n + i});
  }
  for (std::uint32_t i = 1; i + 1 < n; ++i) {
    mesh.triangles.push_back({0, i + 1, i});
    mesh.triangles.push_back({n, n + i, n + i + 1});
  }
  return mesh;
}

// Block w (x) by d (y) by h (z), centred in plan, standing on z = 0.
inline TriangleMesh block(double w, double d, double h) {
  return prism({{-w / 2, -d / 2}, {w / 2, -d / 2}, {w / 2, d / 2}, {-w / 2, d / 2}}, h);
}

inline Ring regular_polygon(int n, double radius, double phase = 0.0) {
  Ring ring;
  for (int i = 0; i < n; ++i) {
    const double a = phase + 2.0 * std::numbers::pi * i / n;
    ring.emplace_back(radius * std::cos(a), radius * std::sin(a));
  }
  return ring;
}

// Surface of revolution stretched to an elliptic section: profile of (radius factor, z) from bottom to top,
// `around` facets; semi-axes ax, ay multiply the radius factor. A radius of 0 at an end is a pole.
inline TriangleMesh revolve(const std::vector<Vec2>& profile, int around, double ax = 1.0, double ay = 1.0) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(around);
  std::vector<std::vector<std::uint32_t>> rings;
  const auto add = [&mesh](double x, double y, double z) {
    mesh.vertices.emplace_back(x, y, z);
    return static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  };
  for (const auto& p : profile) {
    std::vector<std::uint32_t> ring;
    if (p.x() == 0.0) ring.assign(n, add(0, 0, p.y()));
    else
      for (std::uint32_t i = 0; i < n; ++i) {
        const double a = 2.0 * std::numbers::pi * i / n;
        ring.push_back(add(ax * p.x() * std::cos(a), ay * p.x() * std::sin(a), p.y()));
      }
    rings.push_back(std::move(ring));
  }
  const auto face = [&mesh](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    if (a != b && b != c && c != a) mesh.triangles.push_back({a, b, c});
  };
  for (std::size_t k = 0; k + 1 < rings.size(); ++k)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t j = (i + 1) % n;
      face(rings[k][i], rings[k][j], rings[k + 1][j]);
      face(rings[k][i], rings[k + 1][j], rings[k + 1][i]);
    }
  // Flat ends as fans about their own centre.
  if (profile.front().x() > 0.0) {
    const auto centre = add(0, 0, profile.front().y());
    for (std::uint32_t i = 0; i < n; ++i) face(centre, rings.front()[(i + 1) % n], rings.front()[i]);
  }
  if (profile.back().x() > 0.0) {
    const auto centre = add(0, 0, profile.back().y());
    for (std::uint32_t i = 0; i < n; ++i) face(centre, rings.back()[i], rings.back()[(i + 1) % n]);
  }
  return mesh;
}

// Radius r1 at z = 0, r2 at z = height; r1 = r2 cylinder, r2 = 0 cone.
inline TriangleMesh frustum(double r1, double r2, double height, int around) {
  return revolve({{r1, 0.0}, {r2, height}}, around);
}

// Ellipsoid a, b, c about the origin, cut flat at z = -k (0 <= k < c); the cut stands on z = -k.
inline TriangleMesh truncated_ellipsoid(double a, double b, double c, double k, int around) {
  std::vector<Vec2> profile;
  const double start = -std::asin(k / c);
  const int steps = around / 2;
  for (int i = 0; i < steps; ++i) {
    const double latitude = start + (std::numbers::pi / 2 - start) * i / steps;
    profile.emplace_back(std::cos(latitude), c * std::sin(latitude));
  }
  profile.front().y() = -k;
  profile.emplace_back(0.0, c);
  return revolve(profile, around, a, b);
}

// Exact properties, unit density, in the frames above.
inline MassProperties exact_block(double w, double d, double h) {
  MassProperties m;
  m.volume = w * d * h;
  m.centre_of_mass = {0, 0, h / 2};
  m.inertia_per_density = Vec3(d * d + h * h, w * w + h * h, w * w + d * d).asDiagonal();
  m.inertia_per_density *= m.volume / 12.0;
  return m;
}
inline MassProperties exact_frustum(double r1, double r2, double height) {
  const double q = r1 * r1 + r1 * r2 + r2 * r2;
  MassProperties m;
  m.volume = std::numbers::pi * height * q / 3.0;
  const double z = height * (r1 * r1 + 2 * r1 * r2 + 3 * r2 * r2) / (4.0 * q);
  m.centre_of_mass = {0, 0, z};
  // (r2^5 - r1^5)/(r2^3 - r1^3), by polynomial division so that r1 = r2 is no 0/0.
  const double quotient =
      (std::pow(r1, 4) + r1 * r1 * r1 * r2 + r1 * r1 * r2 * r2 + r1 * r2 * r2 * r2 + std::pow(r2, 4)) / q;
  const double about_axis = 0.3 * quotient;
  const double about_base = 0.15 * quotient + height * height / 10.0 * (r1 * r1 + 3 * r1 * r2 + 6 * r2 * r2) / q;
  m.inertia_per_density = Vec3(about_base - z * z, about_base - z * z, about_axis).asDiagonal();
  m.inertia_per_density *= m.volume;
  return m;
}
inline MassProperties exact_truncated_ellipsoid(double a, double b, double c, double k) {
  const double l = c + k, t = c * c * c + k * k * k, f = std::pow(c, 5) + std::pow(k, 5);
  MassProperties m;
  m.volume = std::numbers::pi * a * b * (l - t / (3 * c * c));
  const double z = std::numbers::pi * a * b * std::pow(c * c - k * k, 2) / (4 * c * c) / m.volume;
  m.centre_of_mass = {0, 0, z};
  const double zz = std::numbers::pi * a * b * (t / 3 - f / (5 * c * c));
  const double q = l - 2 * t / (3 * c * c) + f / (5 * std::pow(c, 4));
  const double xx = std::numbers::pi * a * a * a * b * q / 4;
  const double yy = std::numbers::pi * a * b * b * b * q / 4;
  const double zz_com = zz - m.volume * z * z;
  m.inertia_per_density = Vec3(yy + zz_com, xx + zz_com, xx + yy).asDiagonal();
  return m;
}

// Every triangle split into four by its edge midpoints: the same surface.
inline TriangleMesh subdivided(const TriangleMesh& mesh) {
  TriangleMesh fine;
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const auto base = static_cast<std::uint32_t>(fine.vertices.size());
    for (const Vec3& v : {a, b, c, Vec3(0.5 * (a + b)), Vec3(0.5 * (b + c)), Vec3(0.5 * (c + a))})
      fine.vertices.push_back(v);
    for (const Triangle& s : {Triangle{0, 3, 5}, Triangle{3, 1, 4}, Triangle{5, 4, 2}, Triangle{3, 4, 5}})
      fine.triangles.push_back({base + s[0], base + s[1], base + s[2]});
  }
  return geometry::weld(fine);
}

// scale * rotation about z by yaw [rad], then offset.
inline TriangleMesh moved(TriangleMesh mesh, const Vec3& offset, double yaw = 0.0, double scale = 1.0) {
  for (auto& v : mesh.vertices) {
    const Vec3 p = scale * v;
    v = Vec3(std::cos(yaw) * p.x() - std::sin(yaw) * p.y(), std::sin(yaw) * p.x() + std::cos(yaw) * p.y(), p.z()) +
        offset;
  }
  return mesh;
}

}  // namespace cairn::testing
