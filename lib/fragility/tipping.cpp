#include "fragility/tipping.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"

namespace cairn::fragility {
namespace {

using geometry::Vec2;
using geometry::Vec3;

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Indices of the convex hull of `points`, counter-clockwise (monotone chain). Points nearer than
// `slack` to the line of their neighbours are dropped, so that rounding makes no sliver edges.
std::vector<std::size_t> hull_indices(const std::vector<Vec2>& points, double slack) {
  std::vector<std::size_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Vec2 &p = points[a], &q = points[b];
    if (p.x() != q.x()) return p.x() < q.x();
    if (p.y() != q.y()) return p.y() < q.y();
    return a < b;
  });
  order.erase(std::unique(order.begin(), order.end(),
                          [&](std::size_t a, std::size_t b) { return (points[a] - points[b]).norm() <= slack; }),
              order.end());
  if (order.size() < 3) return order;
  std::vector<std::size_t> hull;
  const auto grow = [&](std::size_t next, std::size_t base) {
    while (hull.size() >= base + 2) {
      const Vec2& o = points[hull[hull.size() - 2]];
      const Vec2 chord = points[next] - o;
      if (cross(points[hull.back()] - o, chord) > 0.0) break;
      hull.pop_back();
    }
    hull.push_back(next);
  };
  for (const std::size_t i : order) grow(i, 0);
  const std::size_t lower = hull.size() - 1;
  hull.pop_back();
  for (auto i = order.rbegin(); i != order.rend(); ++i) grow(*i, lower);
  hull.pop_back();
  // Only now, with the corners known: points that rounding scattered about a side are dropped.
  for (std::size_t i = 0; i < hull.size() && hull.size() > 2;) {
    const Vec2& before = points[hull[(i + hull.size() - 1) % hull.size()]];
    const Vec2 chord = points[hull[(i + 1) % hull.size()]] - before;
    if (cross(points[hull[i]] - before, chord) > slack * chord.norm()) ++i;
    else hull.erase(hull.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return hull;
}

// Distance from p to the border of a counter-clockwise convex ring, negative outside any edge's line.
double margin_inside(const std::vector<Vec2>& ring, const Vec2& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 side = ring[(i + 1) % ring.size()] - ring[i];
    least = std::min(least, cross(side, p - ring[i]) / side.norm());
  }
  return least;
}

Edge make_edge(const geometry::MassProperties& mass, const Vec3& from, const Vec3& to) {
  Edge edge;
  edge.ends = {from, to};
  const Vec3 t = (to - from).normalized();
  const Vec3 r_from = mass.centre_of_mass - from;
  const Vec3 r = r_from - r_from.dot(t) * t;
  // Counter-clockwise seen from above, the outward side lies to the right of the edge.
  const Vec2 normal = Vec2(t.y(), -t.x()).normalized();
  const double cos_delta = Vec2(t.x(), t.y()).norm();
  edge.azimuth_deg = base::azimuth_deg(normal.x(), normal.y());
  edge.inclination = std::atan2(std::abs(t.z()), cos_delta);
  const Vec3 outward(normal.x(), normal.y(), 0.0);
  const Vec3 up_in_plane = outward.cross(t);
  const double d = -r.dot(outward);
  const double h = r.dot(up_in_plane);
  edge.r = std::hypot(d, h);
  edge.alpha = std::atan2(d, h);
  edge.inertia_per_mass = t.dot(mass.inertia_per_density * t) / mass.volume + edge.r * edge.r;
  edge.p = std::sqrt(kGravity * edge.r * cos_delta / edge.inertia_per_mass);
  // A steep edge may pass above the centre of mass: no push along its normal topples about it.
  constexpr double kNever = std::numeric_limits<double>::infinity();
  edge.a_qs_g = h > 0.0 ? cos_delta * d / h : kNever;
  edge.v_min =
      h > 0.0 ? 2.0 * kGravity * cos_delta / edge.p * std::sin(0.5 * edge.alpha) / std::cos(edge.alpha) : kNever;
  // 1 - cos(alpha) = 2 sin^2(alpha/2) keeps its digits for slender rocks.
  const double half_sine = std::sin(0.5 * edge.alpha);
  edge.barrier_per_mass = kGravity * edge.r * cos_delta * 2.0 * half_sine * half_sine;
  return edge;
}

// Distance from the origin to the border of a counter-clockwise ring around it, towards u.
double radial(const std::vector<Vec2>& ring, const Vec2& u) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2& a = ring[i];
    const Vec2 side = ring[(i + 1) % ring.size()] - a;
    const double facing = cross(u, side);
    if (facing > 0.0) least = std::min(least, cross(a, side) / facing);
  }
  return least;
}

void fill_azimuths(TippingResult& result, const std::vector<Vec2>& ring) {
  result.a_qs_g_by_azimuth.resize(360);
  for (std::size_t k = 0; k < 360; ++k) {
    const double azimuth = base::deg_to_rad(static_cast<double>(k));
    result.a_qs_g_by_azimuth[k] = radial(ring, Vec2(std::sin(azimuth), std::cos(azimuth)));
  }
  result.a_qs_min_g = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 side = ring[(i + 1) % ring.size()] - ring[i];
    const double distance = cross(ring[i], side) / side.norm();
    if (distance < result.a_qs_min_g) {
      result.a_qs_min_g = distance;
      result.a_qs_min_azimuth_deg = base::azimuth_deg(side.y(), -side.x());
    }
  }
}

}  // namespace

const char* reason_of(Equilibrium state) {
  switch (state) {
    case Equilibrium::stable: return "";
    case Equilibrium::no_contact: return "no_contact";
    case Equilibrium::point_contact: return "point_contact";
    case Equilibrium::line_contact: return "line_contact";
    case Equilibrium::plumb_point_outside: return "not_in_equilibrium";
    case Equilibrium::contact_above_centre: return "contact_above_centre";
  }
  return "";
}

TippingResult tipping(const geometry::MassProperties& mass, std::span<const Vec3> contacts, double tolerance,
                      Azimuths azimuths) {
  if (!(mass.volume > 0.0) || !mass.centre_of_mass.allFinite() || !mass.inertia_per_density.allFinite())
    throw base::Error(base::ErrorCode::failed_precondition, "tipping needs a closed, outward mesh of positive volume");
  TippingResult result;
  if (contacts.empty()) return result;
  const Vec3& c = mass.centre_of_mass;

  // Relative to the centre of mass: coordinates of a projected CRS would cancel badly.
  std::vector<Vec2> plan(contacts.size());
  double extent = 0.0;
  bool below = true;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!contacts[i].allFinite()) throw base::Error(base::ErrorCode::invalid_input, "a contact point is not finite");
    const Vec3 q = contacts[i] - c;
    plan[i] = {q.x(), q.y()};
    extent = std::max(extent, q.norm());
    below = below && q.z() < -tolerance;
  }
  const double slack = 1e-9 * extent;
  const auto outline = hull_indices(plan, slack);
  std::vector<Vec2> outline_plan;
  for (const std::size_t i : outline) {
    result.support.push_back(contacts[i]);
    outline_plan.push_back(plan[i]);
  }
  if (outline.size() < 3) {
    result.equilibrium = outline.size() == 1 ? Equilibrium::point_contact : Equilibrium::line_contact;
    return result;
  }
  result.plumb_margin = margin_inside(outline_plan, Vec2::Zero());
  if (!(result.plumb_margin > tolerance)) {
    result.equilibrium = Equilibrium::plumb_point_outside;
    return result;
  }
  if (!below) {
    result.equilibrium = Equilibrium::contact_above_centre;
    return result;
  }

  std::vector<Vec2> seen(contacts.size());
  double seen_extent = 0.0;
  result.alpha_point = std::numbers::pi;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    seen[i] = plan[i] / (c.z() - contacts[i].z());
    seen_extent = std::max(seen_extent, seen[i].norm());
    result.alpha_point = std::min(result.alpha_point, std::atan(seen[i].norm()));
  }
  const auto border = hull_indices(seen, 1e-9 * seen_extent);
  std::vector<Vec2> ring;
  for (const std::size_t i : border) ring.push_back(seen[i]);
  result.equilibrium = Equilibrium::stable;
  for (std::size_t i = 0; i < border.size(); ++i) {
    const std::size_t a = border[i], b = border[(i + 1) % border.size()];
    Edge edge = make_edge(mass, contacts[a], contacts[b]);
    edge.contacts = {a, b};
    result.edges.push_back(edge);
    if (!result.critical || edge.alpha < result.edges[*result.critical].alpha) result.critical = i;
  }
  if (azimuths == Azimuths::all) fill_azimuths(result, ring);
  return result;
}

std::size_t opposite_edge(const TippingResult& result, std::size_t from) {
  const double azimuth = base::deg_to_rad(result.edges[from].azimuth_deg + 180.0);
  const Vec2 u(std::sin(azimuth), std::cos(azimuth));
  // Of the edges that face u, the one that a push along u reaches first: a_e(u) = a_e / (u . n_e).
  std::size_t best = from;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < result.edges.size(); ++i) {
    const double normal = base::deg_to_rad(result.edges[i].azimuth_deg);
    const double facing = u.dot(Vec2(std::sin(normal), std::cos(normal)));
    if (!(facing > 1e-9)) continue;
    const double reached = result.edges[i].a_qs_g / facing;
    if (reached < least) least = reached, best = i;
  }
  return best;
}

}  // namespace cairn::fragility
