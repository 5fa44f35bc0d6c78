#include "fragility/photo_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/angle.hpp"

namespace cairn::fragility {
namespace {

using geometry::Vec2;
using geometry::Vec3;

struct Slice {
  double z = 0.0;
  std::vector<std::array<Vec2, 2>> segments;
};

// Cuts of the body by horizontal planes in the middle of `count` layers of equal height.
std::vector<Slice> slices_of(const geometry::TriangleMesh& mesh, const Vec3& origin, int count) {
  const auto box = mesh.bounds();
  const double bottom = box.min.z() - origin.z(), step = box.size().z() / count;
  std::vector<Slice> slices(static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) slices[static_cast<std::size_t>(k)].z = bottom + (k + 0.5) * step;
  for (const auto& t : mesh.triangles) {
    std::array<Vec3, 3> p;
    for (std::size_t i = 0; i < 3; ++i) p[i] = mesh.vertices[t[i]] - origin;
    const double lo = std::min({p[0].z(), p[1].z(), p[2].z()}), hi = std::max({p[0].z(), p[1].z(), p[2].z()});
    const int first = std::max(0, static_cast<int>(std::ceil((lo - bottom) / step - 0.5)));
    for (int k = first; k < count && bottom + (k + 0.5) * step < hi; ++k) {
      auto& slice = slices[static_cast<std::size_t>(k)];
      std::array<Vec2, 2> ends;
      std::size_t found = 0;
      for (std::size_t i = 0; i < 3 && found < 2; ++i) {
        const Vec3 &a = p[i], &b = p[(i + 1) % 3];
        if ((a.z() < slice.z) == (b.z() < slice.z)) continue;
        const double f = (slice.z - a.z()) / (b.z() - a.z());
        ends[found++] = a.head<2>() + f * (b.head<2>() - a.head<2>());
      }
      if (found == 2) slice.segments.push_back(ends);
    }
  }
  return slices;
}

struct Silhouette {
  double across = 0.0, up = 0.0;  // of the area centroid
};

// A line of sight that crosses a slice crosses its border, so the slice's shadow is that of its border.
Silhouette silhouette(const std::vector<Slice>& slices, const Vec2& right) {
  double area = 0.0, first = 0.0, moment = 0.0;
  std::vector<std::pair<double, double>> spans;
  for (const auto& slice : slices) {
    spans.clear();
    for (const auto& s : slice.segments) {
      const double a = right.dot(s[0]), b = right.dot(s[1]);
      spans.emplace_back(std::min(a, b), std::max(a, b));
    }
    std::sort(spans.begin(), spans.end());
    double reached = -std::numeric_limits<double>::infinity();
    for (const auto& [lo, hi] : spans) {
      const double from = std::max(lo, reached);
      if (hi <= from) continue;
      const double width = hi - from;
      area += width;
      first += width * 0.5 * (hi + from);
      moment += width * slice.z;
      reached = hi;
    }
  }
  return {first / area, moment / area};
}

}  // namespace

std::vector<survey::PhotoView> photo_views(const geometry::TriangleMesh& mesh, std::span<const Vec3> contact,
                                           double step_deg, int slices) {
  std::vector<survey::PhotoView> views;
  if (mesh.triangles.empty() || contact.empty()) return views;
  const Vec3 origin = mesh.bounds().centre();
  const auto cuts = slices_of(mesh, origin, slices);
  for (int k = 0; k * step_deg < 180.0 - 1e-9; ++k) {
    survey::PhotoView view;
    view.view_azimuth_deg = k * step_deg;
    const double azimuth = base::deg_to_rad(view.view_azimuth_deg);
    const Vec2 right(std::cos(azimuth), -std::sin(azimuth));  // 90 deg clockwise of the view
    const auto centre = silhouette(cuts, right);
    Vec3 left_end = contact.front(), right_end = contact.front();
    for (const auto& q : contact) {
      if (right.dot((q - left_end).head<2>()) < 0.0) left_end = q;
      if (right.dot((q - right_end).head<2>()) > 0.0) right_end = q;
    }
    const auto angle = [&](const Vec3& end, double side, double& alpha, double& r) {
      const double d = side * (right.dot((end - origin).head<2>()) - centre.across);
      const double h = centre.up - (end.z() - origin.z());
      alpha = std::atan2(d, h);
      r = std::hypot(d, h);
    };
    angle(left_end, -1.0, view.alpha_left_rad, view.r_left_m);
    angle(right_end, 1.0, view.alpha_right_rad, view.r_right_m);
    views.push_back(view);
  }
  return views;
}

}  // namespace cairn::fragility
