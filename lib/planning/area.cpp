#include "planning/area.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::planning {
namespace {

using geometry::Ring;
using geometry::Vec2;

constexpr std::size_t kMostVertices = 20'000;

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double side(const Vec2& a, const Vec2& b, const Vec2& p) {
  return cross(b - a, p - a);
}

bool on_segment(const Vec2& a, const Vec2& b, const Vec2& p) {
  return side(a, b, p) == 0.0 && (p - a).dot(p - b) <= 0.0;
}

bool meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const double s1 = side(a, b, c), s2 = side(a, b, d), s3 = side(c, d, a), s4 = side(c, d, b);
  if (((s1 > 0.0) != (s2 > 0.0)) && s1 != 0.0 && s2 != 0.0 && ((s3 > 0.0) != (s4 > 0.0)) && s3 != 0.0 && s4 != 0.0)
    return true;
  return on_segment(a, b, c) || on_segment(a, b, d) || on_segment(c, d, a) || on_segment(c, d, b);
}

[[noreturn]] void refuse(std::size_t ring, std::string message, std::string found, std::string allowed) {
  throw base::Error(base::ErrorCode::invalid_input, std::move(message))
      .record("ring " + std::to_string(ring))
      .found(std::move(found))
      .allowed(std::move(allowed));
}

std::string text_of(const Vec2& p) {
  return "(" + base::to_fixed(p.x(), 2) + ", " + base::to_fixed(p.y(), 2) + ") m";
}

void check_ring(const Ring& ring, std::size_t index) {
  for (const Vec2& p : ring)
    if (!p.allFinite()) refuse(index, "a vertex of the area is not finite", "nan or inf", "finite coordinates");
  if (ring.size() > kMostVertices)
    refuse(index, "the area has too many vertices", std::to_string(ring.size()),
           "at most " + std::to_string(kMostVertices));
  const std::size_t n = ring.size();
  if (n < 3) refuse(index, "the area encloses nothing", std::to_string(n) + " vertices", "3 or more");
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % n], &c = ring[(i + 2) % n];
    if (a == b) refuse(index, "two successive vertices of the area are the same", text_of(a), "distinct vertices");
    // Back on itself: the next edge returns along this one.
    if (side(a, b, c) == 0.0 && (b - a).dot(c - b) < 0.0)
      refuse(index, "the area's border runs back on itself", "at " + text_of(b), "a simple polygon");
    for (std::size_t j = i + 2; j < n; ++j) {
      if (i == 0 && j + 1 == n) continue;  // neighbours share a vertex
      if (meet(a, b, ring[j], ring[(j + 1) % n]))
        refuse(index, "the area's border crosses or touches itself",
               "edges " + std::to_string(i + 1) + " and " + std::to_string(j + 1) + ", near " + text_of(b),
               "a simple polygon; draw a self-crossing one as several");
    }
  }
  if (geometry::signed_area(ring) == 0.0) refuse(index, "the area encloses nothing", "0 m^2", "above 0");
}

// Along-track and across-track coordinates.
Vec2 turned(const Vec2& p, double azimuth) {
  const double s = std::sin(azimuth), c = std::cos(azimuth);
  return {p.x() * s + p.y() * c, p.x() * c - p.y() * s};
}

}  // namespace

void check_area(const Area& area) {
  if (area.empty()) throw base::Error(base::ErrorCode::invalid_input, "there is no area").allowed("a polygon");
  for (std::size_t i = 0; i < area.size(); ++i) check_ring(area[i], i);
}

bool inside(const Area& area, const Vec2& p) {
  bool odd = false;
  for (const Ring& ring : area) odd ^= geometry::contains(ring, p);
  return odd;
}

std::pair<double, double> across_range(const Area& area, double azimuth) {
  std::pair<double, double> range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Ring& ring : area)
    for (const Vec2& p : ring) {
      const double across = turned(p, azimuth).y();
      range.first = std::min(range.first, across);
      range.second = std::max(range.second, across);
    }
  return range;
}

std::vector<std::pair<double, double>> strip_extents(const Area& area, double azimuth, double low, double high) {
  std::vector<std::pair<Vec2, Vec2>> edges;  // (along, across), lower across first
  std::vector<double> levels{low, high};
  for (const Ring& ring : area)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      Vec2 a = turned(ring[i], azimuth), b = turned(ring[(i + 1) % ring.size()], azimuth);
      if (a.y() > b.y()) std::swap(a, b);
      if (b.y() < low || a.y() > high || a.y() == b.y()) continue;
      edges.emplace_back(a, b);
      for (const double across : {a.y(), b.y()})
        if (across > low && across < high) levels.push_back(across);
    }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());

  // Between two levels the area is a row of trapezia: edges in pairs, sorted by their middle.
  std::vector<std::pair<double, double>> extents;
  struct Crossing {
    double middle, least, most;
  };
  std::vector<Crossing> row;
  for (std::size_t k = 0; k + 1 < levels.size(); ++k) {
    const double bottom = levels[k], top = levels[k + 1];
    row.clear();
    for (const auto& [a, b] : edges) {
      if (a.y() > bottom || b.y() < top) continue;
      const auto along = [&a = a, &b = b](double across) {
        return a.x() + (b.x() - a.x()) * (across - a.y()) / (b.y() - a.y());
      };
      const double at_bottom = along(bottom), at_top = along(top);
      row.push_back({along(0.5 * (bottom + top)), std::min(at_bottom, at_top), std::max(at_bottom, at_top)});
    }
    std::sort(row.begin(), row.end(), [](const Crossing& a, const Crossing& b) { return a.middle < b.middle; });
    for (std::size_t i = 0; i + 1 < row.size(); i += 2) extents.emplace_back(row[i].least, row[i + 1].most);
  }
  std::sort(extents.begin(), extents.end());
  std::vector<std::pair<double, double>> joined;
  for (const auto& e : extents) {
    if (!joined.empty() && e.first <= joined.back().second)
      joined.back().second = std::max(joined.back().second, e.second);
    else joined.push_back(e);
  }
  return joined;
}

double narrowest_azimuth(const Area& area) {
  std::vector<Vec2> points;
  for (const Ring& ring : area) points.insert(points.end(), ring.begin(), ring.end());
  const Ring hull = geometry::convex_hull(std::move(points));
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vec2 edge = hull[(i + 1) % hull.size()] - hull[i];
    double azimuth = std::atan2(edge.x(), edge.y());
    if (azimuth < 0.0) azimuth += std::numbers::pi;
    if (azimuth >= std::numbers::pi) azimuth -= std::numbers::pi;
    const auto [low, high] = across_range(area, azimuth);
    // Of equal widths the first: a tie must not hang on the last digit.
    if (high - low < least * (1.0 - 1e-9)) {
      least = high - low;
      best = azimuth;
    }
  }
  return best;
}

}  // namespace cairn::planning
