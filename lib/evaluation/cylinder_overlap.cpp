#include "evaluation/cylinder_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::evaluation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

// m: rounding of coordinates in mesh files (float32 at 100 m).
constexpr double kRounding = 1e-4;
// m: a patch's centre lies this near above its rim and is still under the rock.
constexpr double kRimThickness = 0.01;

bool in_contact(const survey::TruthObject& object, const Vec3& centre, const Vec3& normal) {
  if (normal.z() >= 0.0) return false;
  for (const auto& rim : object.contact_rim) {
    geometry::Ring plan;
    double highest = -std::numeric_limits<double>::infinity();
    for (const auto& p : rim) {
      plan.emplace_back(p.x(), p.y());
      highest = std::max(highest, p.z());
    }
    if (plan.size() >= 3 && centre.z() <= highest + kRimThickness && geometry::contains(plan, centre.head<2>()))
      return true;
  }
  return false;
}

}  // namespace

double volume(const geometry::VerticalCylinder& cylinder) {
  return std::numbers::pi * cylinder.radius * cylinder.radius * cylinder.height();
}

double circle_intersection(const Vec2& a, double radius_a, const Vec2& b, double radius_b) {
  const double distance = (a - b).norm();
  if (distance >= radius_a + radius_b) return 0.0;
  const double small = std::min(radius_a, radius_b), large = std::max(radius_a, radius_b);
  if (distance <= large - small) return std::numbers::pi * small * small;
  // Two circular segments, cut by the common chord.
  const auto segment = [distance](double r, double other) {
    const double to_chord = (distance * distance + r * r - other * other) / (2.0 * distance);
    const double half_angle = std::acos(std::clamp(to_chord / r, -1.0, 1.0));
    return r * r * (half_angle - std::sin(half_angle) * std::cos(half_angle));
  };
  return segment(radius_a, radius_b) + segment(radius_b, radius_a);
}

double iou(const geometry::VerticalCylinder& a, const geometry::VerticalCylinder& b) {
  const double height = std::max(0.0, std::min(a.top, b.top) - std::max(a.bottom, b.bottom));
  const double both = height * circle_intersection(a.axis, a.radius, b.axis, b.radius);
  const double either = volume(a) + volume(b) - both;
  return either > 0.0 ? std::clamp(both / either, 0.0, 1.0) : 0.0;
}

std::vector<SurfacePatch> exposed_surface(const geometry::TriangleMesh& mesh, const survey::TruthObject& object,
                                          double step_m) {
  constexpr double kMostParts = 256.0;  // of an edge: bounds what one vast triangle costs
  std::vector<SurfacePatch> patches;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& corners = mesh.triangles[t];
    const Vec3 a = mesh.vertices[corners[0]], ab = mesh.vertices[corners[1]] - a, ac = mesh.vertices[corners[2]] - a;
    const Vec3 normal = mesh.area_vector(t);
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int parts = static_cast<int>(std::clamp(std::ceil(longest / step_m), 1.0, kMostParts));
    const double n = parts, area = normal.norm() / (n * n);
    if (!(area > 0.0)) continue;
    const auto take = [&](double u, double v) {
      const Vec3 centre = a + (u / n) * ab + (v / n) * ac;
      if (centre.z() < object.cylinder.bottom - kRounding || in_contact(object, centre, normal)) return;
      patches.push_back({centre, area});
    };
    // n^2 equal triangles: those that point as the whole does, and those that stand on their head between them.
    for (int i = 0; i < parts; ++i)
      for (int j = 0; i + j < parts; ++j) {
        take(i + 1.0 / 3.0, j + 1.0 / 3.0);
        if (i + j + 1 < parts) take(i + 2.0 / 3.0, j + 2.0 / 3.0);
      }
  }
  return patches;
}

std::optional<double> contained_share(const std::vector<SurfacePatch>& surface,
                                      const geometry::VerticalCylinder& cylinder) {
  double all = 0.0, inside = 0.0;
  for (const auto& patch : surface) {
    all += patch.area_m2;
    const bool in_height =
        patch.centre.z() >= cylinder.bottom - kRounding && patch.centre.z() <= cylinder.top + kRounding;
    if (in_height && (patch.centre.head<2>() - cylinder.axis).norm() <= cylinder.radius + kRounding)
      inside += patch.area_m2;
  }
  if (!(all > 0.0)) return std::nullopt;
  return inside / all;
}

}  // namespace cairn::evaluation
