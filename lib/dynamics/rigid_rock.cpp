#include "dynamics/rigid_rock.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::dynamics {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Indices of the convex hull's corners, counter-clockwise; Andrew's monotone chain, collinear points dropped.
std::vector<std::size_t> hull_of(const std::vector<Vec2>& points) {
  std::vector<std::size_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    if (points[a].x() != points[b].x()) return points[a].x() < points[b].x();
    if (points[a].y() != points[b].y()) return points[a].y() < points[b].y();
    return a < b;
  });
  order.erase(
      std::unique(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return points[a] == points[b]; }),
      order.end());
  if (order.size() < 3) return order;
  std::vector<std::size_t> hull;
  const auto extend = [&](auto begin, auto end, std::size_t keep) {
    for (auto it = begin; it != end; ++it) {
      while (hull.size() >= keep && turn(points[hull[hull.size() - 2]], points[hull.back()], points[*it]) <= 0.0)
        hull.pop_back();
      hull.push_back(*it);
    }
    hull.pop_back();
  };
  extend(order.begin(), order.end(), 2);
  extend(order.rbegin(), order.rend(), hull.size() + 2);
  return hull;
}

Vec3 middle_of(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const auto& p : points) sum += p;
  return sum / static_cast<double>(points.size());
}

// Least-squares plane z = a x + b y + c.
Vec3 plane_normal(const std::vector<Vec3>& points, const Vec3& middle) {
  geometry::Mat2 m = geometry::Mat2::Zero();
  Vec2 b = Vec2::Zero();
  for (const auto& p : points) {
    const Vec3 d = p - middle;
    m += d.head<2>() * d.head<2>().transpose();
    b += d.head<2>() * d.z();
  }
  const Vec2 slope = m.inverse() * b;
  return Vec3(-slope.x(), -slope.y(), 1.0).normalized();
}

std::vector<Vec3> sphere_directions(std::int64_t count) {
  std::vector<Vec3> directions;
  const double golden = std::numbers::pi * (3.0 - std::sqrt(5.0));
  for (std::int64_t i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
    const double r = std::sqrt(std::max(0.0, 1.0 - z * z)), a = golden * static_cast<double>(i);
    directions.emplace_back(r * std::cos(a), r * std::sin(a), z);
  }
  return directions;
}

// The farthest points in each direction, each once, in order of the directions.
std::vector<Vec3> extreme_points(const std::vector<Vec3>& points, const std::vector<Vec3>& directions) {
  std::vector<Vec3> out;
  std::vector<std::size_t> used;
  for (const auto& d : directions) {
    std::size_t best = 0;
    double most = points.front().dot(d);
    for (std::size_t i = 1; i < points.size(); ++i)
      if (const double s = points[i].dot(d); s > most) {
        most = s;
        best = i;
      }
    if (std::find(used.begin(), used.end(), best) == used.end()) {
      used.push_back(best);
      out.push_back(points[best]);
    }
  }
  return out;
}

// What of the mesh lies between two heights above the pads: its vertices there and where its edges cross.
std::vector<Vec3> slice_points(const geometry::TriangleMesh& mesh, const std::vector<double>& height, double low,
                               double high) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (height[i] >= low && height[i] <= high) points.push_back(mesh.vertices[i]);
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      for (const double level : {low, high}) {
        if ((height[a] < level) == (height[b] < level) || a > b) continue;
        const double f = (level - height[a]) / (height[b] - height[a]);
        points.emplace_back((1.0 - f) * mesh.vertices[a] + f * mesh.vertices[b]);
      }
    }
  return points;
}

}  // namespace

void RigidRockOptions::visit(base::OptionVisitor& visitor) {
  visitor.integer("flank-slabs", slabs, 1, 64, "3-D check: the flanks are convex hulls of this many level slices");
  visitor.real("flank-clearance-m", clearance_m, 0.0, 1.0, "3-D check: slices begin this far above the contact");
  visitor.integer("flank-directions", directions, 16, 1000, "3-D check: corners kept of each slice");
}

RigidRock rigid_rock(const geometry::TriangleMesh& mesh, const geometry::MassProperties& mass, double density_kg_m3,
                     std::span<const Vec3> contacts, const RigidRockOptions& options) {
  const auto refuse = [](const std::string& why, const std::string& found) {
    return Error(ErrorCode::failed_precondition, "the contact cannot hold the rock up: " + why).found(found);
  };
  if (!(mass.volume > 0.0) || !(density_kg_m3 > 0.0))
    throw Error(ErrorCode::failed_precondition, "a rigid body needs a positive volume and density")
        .found(base::to_text(mass.volume) + " m3, " + base::to_text(density_kg_m3) + " kg/m3");
  RigidRock rock;
  rock.mass_kg = density_kg_m3 * mass.volume;
  rock.centre_of_mass_m = mass.centre_of_mass;
  rock.inertia_kg_m2 = density_kg_m3 * mass.inertia_per_density;

  std::vector<Vec2> projected;
  for (const auto& q : contacts) {
    const double below = mass.centre_of_mass.z() - q.z();
    if (!(below > 0.0)) throw refuse("a contact is not below the centre of mass", base::to_text(q.z()) + " m");
    projected.emplace_back((q - mass.centre_of_mass).head<2>() / below);
  }
  const auto hull = hull_of(projected);
  if (hull.size() < 3) throw refuse("fewer than three corners", std::to_string(hull.size()));
  for (std::size_t i = 0; i < hull.size(); ++i)
    if (turn(projected[hull[i]], projected[hull[(i + 1) % hull.size()]], Vec2::Zero()) <= 0.0)
      throw refuse("the plumb point lies outside", "corner " + std::to_string(hull[i]));
  for (const auto i : hull) rock.foot_m.push_back(contacts[i]);
  const Vec3 middle = middle_of(rock.foot_m);
  rock.pad_normal = plane_normal(rock.foot_m, middle);
  for (const auto& q : rock.foot_m)
    rock.foot_off_plane_m = std::max(rock.foot_off_plane_m, std::abs(rock.pad_normal.dot(q - middle)));

  std::vector<double> height;
  height.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) height.push_back(rock.pad_normal.dot(v - middle));
  if (height.empty()) return rock;
  const double top = *std::max_element(height.begin(), height.end());
  const double bottom = rock.foot_off_plane_m + options.clearance_m;
  const auto directions = sphere_directions(options.directions);
  for (std::int64_t i = 0; i < options.slabs && bottom < top; ++i) {
    const double step = (top - bottom) / static_cast<double>(options.slabs);
    const auto points =
        slice_points(mesh, height, bottom + step * static_cast<double>(i), bottom + step * static_cast<double>(i + 1));
    if (points.size() < 4) continue;
    rock.pieces_m.push_back(extreme_points(points, directions));
  }
  return rock;
}

}  // namespace cairn::dynamics
