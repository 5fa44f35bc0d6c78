#include "geometry/enclosing_circle.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "geometry/primitives.hpp"

namespace cairn::geometry {
namespace {

constexpr double kSlack = 1e-12;  // of the radius: rounding of the circle through three points

bool inside(const Circle& c, const Vec2& p) {
  return (p - c.centre).norm() <= c.radius * (1.0 + kSlack);
}

Circle through(const Vec2& a, const Vec2& b) {
  const Vec2 centre = 0.5 * (a + b);
  return {centre, std::max((a - centre).norm(), (b - centre).norm())};
}

// Circumcircle; of collinear points the circle over the longest side.
Circle through(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 ab = b - a, ac = c - a;
  const double cross = 2.0 * (ab.x() * ac.y() - ab.y() * ac.x());
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (c - b).squaredNorm()});
  if (std::abs(cross) <= 1e-14 * longest) {
    Circle best = through(a, b);
    for (const Circle& other : {through(a, c), through(b, c)})
      if (other.radius > best.radius) best = other;
    return best;
  }
  const Vec2 offset(ac.y() * ab.squaredNorm() - ab.y() * ac.squaredNorm(),
                    ab.x() * ac.squaredNorm() - ac.x() * ab.squaredNorm());
  const Vec2 centre = a + offset / cross;
  return {centre, std::max({(a - centre).norm(), (b - centre).norm(), (c - centre).norm()})};
}

}  // namespace

Circle smallest_enclosing_circle(const std::vector<Vec2>& points) {
  if (points.empty()) return {};
  std::vector<Vec2> hull = convex_hull(points);
  // A fixed shuffle keeps the expected cost linear: hull vertices come in order round the hull.
  std::uint64_t state = 0x9E3779B97F4A7C15ULL;
  for (std::size_t i = hull.size(); i > 1; --i) {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    std::swap(hull[i - 1], hull[(state >> 33U) % i]);
  }
  Circle circle{hull[0], 0.0};
  for (std::size_t i = 1; i < hull.size(); ++i) {
    if (inside(circle, hull[i])) continue;
    circle = {hull[i], 0.0};
    for (std::size_t j = 0; j < i; ++j) {
      if (inside(circle, hull[j])) continue;
      circle = through(hull[i], hull[j]);
      for (std::size_t k = 0; k < j; ++k)
        if (!inside(circle, hull[k])) circle = through(hull[i], hull[j], hull[k]);
    }
  }
  return circle;
}

}  // namespace cairn::geometry
