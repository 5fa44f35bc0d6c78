#include "simulation/vehicle_contact.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::simulation {
namespace {

using geometry::Ring;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Plan of the part of a surface below `top`: its vertices there and the points where edges cross it.
Ring low_outline(const geometry::TriangleMesh& mesh, double top) {
  std::vector<Vec2> points;
  for (const auto& triangle : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& a = mesh.vertices[triangle[k]];
      const Vec3& b = mesh.vertices[triangle[(k + 1) % 3]];
      if (a.z() <= top) points.emplace_back(a.head<2>());
      if ((a.z() <= top) == (b.z() <= top)) continue;
      points.emplace_back((a + (b - a) * ((top - a.z()) / (b.z() - a.z()))).head<2>());
    }
  return geometry::convex_hull(std::move(points));
}

double point_to_edge(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (p - (a + t * along)).norm();
}

// Whether a line along an edge of `a` has all of `b` on its outer side.
bool separated_by_edge_of(const Ring& a, const Ring& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec2 edge = a[(i + 1) % a.size()] - a[i];
    const Vec2 outward(edge.y(), -edge.x());
    if (std::all_of(b.begin(), b.end(), [&](const Vec2& p) { return (p - a[i]).dot(outward) > 0.0; })) return true;
  }
  return false;
}

double vertices_to_edges(const Ring& a, const Ring& b) {
  double least = kInfinity;
  for (const Vec2& p : a)
    for (std::size_t i = 0; i < b.size(); ++i) least = std::min(least, point_to_edge(p, b[i], b[(i + 1) % b.size()]));
  return least;
}

}  // namespace

double convex_distance(const Ring& a, const Ring& b) {
  if (a.empty() || b.empty()) return kInfinity;
  if (a.size() >= 3 && b.size() >= 3 && !separated_by_edge_of(a, b) && !separated_by_edge_of(b, a)) return 0.0;
  return std::min(vertices_to_edges(a, b), vertices_to_edges(b, a));
}

VehicleContact::VehicleContact(std::span<const PlacedObject> objects, const VehicleBody& body) : body_(body) {
  for (const PlacedObject& object : objects) {
    outlines_.push_back(low_outline(object.exposed, object.truth.cylinder.bottom + body.height_m));
    Vec2 middle = Vec2::Zero();
    for (const Vec2& p : outlines_.back()) middle += p;
    if (!outlines_.back().empty()) middle /= static_cast<double>(outlines_.back().size());
    double radius = 0.0;
    for (const Vec2& p : outlines_.back()) radius = std::max(radius, (p - middle).norm());
    middle_.push_back(middle);
    radius_.push_back(radius);
  }
}

VehicleContact::Nearest VehicleContact::nearest(const Vec2& centre, double yaw) const {
  const Vec2 ahead(0.5 * body_.length_m * std::cos(yaw), 0.5 * body_.length_m * std::sin(yaw));
  const Vec2 left(-0.5 * body_.width_m * std::sin(yaw), 0.5 * body_.width_m * std::cos(yaw));
  const Ring rectangle{centre - ahead - left, centre + ahead - left, centre + ahead + left, centre - ahead + left};
  const double reach = (ahead + left).norm();
  Nearest result{kInfinity, 0};
  for (std::size_t i = 0; i < outlines_.size(); ++i) {
    if (outlines_[i].empty() || (middle_[i] - centre).norm() - radius_[i] - reach > result.distance_m) continue;
    const double distance = convex_distance(rectangle, outlines_[i]);
    if (distance < result.distance_m) result = {distance, i};
  }
  return result;
}

}  // namespace cairn::simulation
