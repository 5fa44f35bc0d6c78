#include "report/rock_view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/angle.hpp"

namespace cairn::report {

using geometry::Vec2;
using geometry::Vec3;

SideView::SideView(double azimuth) : azimuth_deg(azimuth) {
  const double a = base::deg_to_rad(azimuth);
  ahead = Vec3(std::sin(a), std::cos(a), 0.0);
  right = Vec3(std::cos(a), -std::sin(a), 0.0);
}

namespace {

struct Canvas {
  ShadedView out;
  std::vector<double> depth;

  // Pixels whose centre lies in the triangle; the nearer surface wins.
  void fill(const std::array<Vec2, 3>& p, const std::array<double, 3>& d, const Rgba& colour) {
    const double area = (p[1] - p[0]).x() * (p[2] - p[0]).y() - (p[1] - p[0]).y() * (p[2] - p[0]).x();
    if (!(std::abs(area) > 0.0)) return;
    const auto width = static_cast<double>(out.image.width), height = static_cast<double>(out.image.height);
    const auto low = [](double v, double most) {
      return static_cast<std::size_t>(std::clamp(std::floor(v), 0.0, most));
    };
    const std::size_t c0 = low(std::min({p[0].x(), p[1].x(), p[2].x()}), width),
                      c1 = low(std::max({p[0].x(), p[1].x(), p[2].x()}) + 1.0, width),
                      r0 = low(std::min({p[0].y(), p[1].y(), p[2].y()}), height),
                      r1 = low(std::max({p[0].y(), p[1].y(), p[2].y()}) + 1.0, height);
    for (std::size_t r = r0; r < r1; ++r)
      for (std::size_t c = c0; c < c1; ++c) {
        const Vec2 q(static_cast<double>(c) + 0.5, static_cast<double>(r) + 0.5);
        const auto weight = [&](const Vec2& a, const Vec2& b) {
          return ((b - a).x() * (q - a).y() - (b - a).y() * (q - a).x()) / area;
        };
        const double w0 = weight(p[1], p[2]), w1 = weight(p[2], p[0]), w2 = weight(p[0], p[1]);
        if (w0 < 0.0 || w1 < 0.0 || w2 < 0.0) continue;
        const double z = w0 * d[0] + w1 * d[1] + w2 * d[2];
        const std::size_t i = r * out.image.width + c;
        if (z >= depth[i]) continue;
        depth[i] = z;
        out.image.pixels[i] = colour;
      }
  }
};

}  // namespace

ShadedView shaded_view(const geometry::TriangleMesh& mesh, const SideView& view, std::size_t longest_px) {
  Canvas canvas;
  if (mesh.vertices.empty() || longest_px == 0) return canvas.out;
  Vec2 low = view(mesh.vertices.front()), high = low;
  for (const auto& v : mesh.vertices) {
    low = low.cwiseMin(view(v));
    high = high.cwiseMax(view(v));
  }
  const Vec2 size = (high - low).cwiseMax(1e-6);
  const double pixel = size.maxCoeff() / static_cast<double>(longest_px);
  canvas.out.low = low;
  canvas.out.pixel_m = pixel;
  canvas.out.image.width = static_cast<std::size_t>(std::ceil(size.x() / pixel));
  canvas.out.image.height = static_cast<std::size_t>(std::ceil(size.y() / pixel));
  canvas.out.image.pixels.assign(canvas.out.image.width * canvas.out.image.height, Rgba{0, 0, 0, 0});
  canvas.depth.assign(canvas.out.image.pixels.size(), std::numeric_limits<double>::infinity());
  const double rows = static_cast<double>(canvas.out.image.height);
  const Vec3 light = (-view.ahead - 0.6 * view.right + 0.8 * Vec3::UnitZ()).normalized();
  const bool coloured = mesh.colours.size() == mesh.vertices.size();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 area = mesh.area_vector(t);
    const double norm = area.norm();
    if (!(norm > 0.0) || area.dot(view.ahead) > 0.0) continue;  // faces away
    const double shade = 0.35 + 0.65 * std::max(0.0, area.dot(light) / norm);
    std::array<Vec2, 3> p;
    std::array<double, 3> d{};
    std::array<double, 3> tone{200.0, 190.0, 178.0};
    if (coloured) tone = {0.0, 0.0, 0.0};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t v = mesh.triangles[t][k];
      const Vec2 q = (view(mesh.vertices[v]) - low) / pixel;
      p[k] = {q.x(), rows - q.y()};
      d[k] = view.ahead.dot(mesh.vertices[v]);
      if (coloured)
        for (std::size_t c = 0; c < 3; ++c) tone[c] += mesh.colours[v][c] / 3.0;
    }
    Rgba colour{0, 0, 0, 255};
    for (std::size_t c = 0; c < 3; ++c)
      colour[c] = static_cast<std::uint8_t>(std::clamp(std::lround(tone[c] * shade), 0L, 255L));
    canvas.fill(p, d, colour);
  }
  return canvas.out;
}

}  // namespace cairn::report
