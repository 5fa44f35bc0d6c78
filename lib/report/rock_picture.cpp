#include "report/rock_picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/angle.hpp"

namespace cairn::report {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr std::size_t kFine = 2;               // samples a pixel along each side
constexpr std::size_t kLevels = kSeenColours;  // of light, for each tint
constexpr std::uint8_t kNothing = 0;           // palette index

std::vector<Rgba> palette() {
  std::vector<Rgba> colours{{255, 255, 255, 0}};
  const std::array<std::array<double, 3>, 2> tints{{{196, 184, 166}, {214, 150, 110}}};  // seen, closed by the cap
  for (const auto& tint : tints)
    for (std::size_t i = 0; i < kLevels; ++i) {
      const double light = 0.22 + 0.98 * static_cast<double>(i) / (kLevels - 1);
      Rgba c{0, 0, 0, 255};
      for (std::size_t k = 0; k < 3; ++k)
        c[k] = static_cast<std::uint8_t>(std::clamp(std::lround(tint[k] * light), 0L, 255L));
      colours.push_back(c);
    }
  return colours;
}

struct Sample {
  float light = 0.0F;
  bool seen = true, hit = false;
};

}  // namespace

RockPicture draw_rock(const geometry::TriangleMesh& mesh, const std::vector<std::uint8_t>& facet_seen,
                      double right_azimuth_deg, std::size_t width_px, std::size_t height_px, std::size_t margin_px) {
  RockPicture picture;
  picture.image.width = width_px;
  picture.image.height = height_px;
  picture.image.palette = palette();
  picture.image.pixels.assign(width_px * height_px, kNothing);
  const double azimuth = base::deg_to_rad(right_azimuth_deg);
  picture.right = {std::sin(azimuth), std::cos(azimuth), 0.0};
  const Vec3 sight(-picture.right.y(), picture.right.x(), 0.0);  // up x right: right lies to the right of it
  if (mesh.triangles.empty()) return picture;

  double lo = std::numeric_limits<double>::infinity(), hi = -lo, bottom = lo, top = -lo;
  for (const auto& v : mesh.vertices) {
    const double u = v.dot(picture.right);
    lo = std::min(lo, u);
    hi = std::max(hi, u);
    bottom = std::min(bottom, v.z());
    top = std::max(top, v.z());
  }
  const double room_x = static_cast<double>(width_px) - 2.0 * static_cast<double>(margin_px);
  const double room_y = static_cast<double>(height_px) - 2.0 * static_cast<double>(margin_px);
  picture.m_per_px = std::max({(hi - lo) / std::max(room_x, 1.0), (top - bottom) / std::max(room_y, 1.0), 1e-9});
  picture.left_m = 0.5 * (lo + hi) - 0.5 * static_cast<double>(width_px) * picture.m_per_px;
  picture.top_m = 0.5 * (bottom + top) + 0.5 * static_cast<double>(height_px) * picture.m_per_px;

  const std::size_t columns = width_px * kFine, rows = height_px * kFine;
  std::vector<float> depth(columns * rows, std::numeric_limits<float>::infinity());
  std::vector<Sample> samples(columns * rows);
  const Vec3 light = (-0.55 * picture.right + 0.65 * Vec3::UnitZ() - 0.55 * sight).normalized();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& triangle = mesh.triangles[t];
    std::array<Vec2, 3> p;
    std::array<double, 3> far{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& v = mesh.vertices[triangle[k]];
      p[k] = picture.pixel(v) * static_cast<double>(kFine);
      far[k] = v.dot(sight);
    }
    const Vec3 normal = mesh.area_vector(t);
    const double twice = (p[1] - p[0]).x() * (p[2] - p[0]).y() - (p[1] - p[0]).y() * (p[2] - p[0]).x();
    if (!(std::abs(twice) > 1e-12) || normal.dot(sight) >= 0.0) continue;  // seen from behind, or on edge
    const double lit = std::max(0.0, normal.normalized().dot(light));
    const auto range = [](double least, double greatest, std::size_t n) {
      const auto from = static_cast<std::ptrdiff_t>(std::ceil(least - 0.5));
      const auto to = static_cast<std::ptrdiff_t>(std::floor(greatest - 0.5));
      return std::pair{std::max<std::ptrdiff_t>(from, 0),
                       std::min<std::ptrdiff_t>(to, static_cast<std::ptrdiff_t>(n) - 1)};
    };
    const auto [x0, x1] =
        range(std::min({p[0].x(), p[1].x(), p[2].x()}), std::max({p[0].x(), p[1].x(), p[2].x()}), columns);
    const auto [y0, y1] =
        range(std::min({p[0].y(), p[1].y(), p[2].y()}), std::max({p[0].y(), p[1].y(), p[2].y()}), rows);
    for (std::ptrdiff_t y = y0; y <= y1; ++y)
      for (std::ptrdiff_t x = x0; x <= x1; ++x) {
        const Vec2 q(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
        const auto cross = [](const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); };
        const double w0 = cross(p[2] - p[1], q - p[1]) / twice, w1 = cross(p[0] - p[2], q - p[2]) / twice,
                     w2 = cross(p[1] - p[0], q - p[0]) / twice;
        if (w0 < -1e-9 || w1 < -1e-9 || w2 < -1e-9) continue;
        const auto d = static_cast<float>(w0 * far[0] + w1 * far[1] + w2 * far[2]);
        const std::size_t at = static_cast<std::size_t>(y) * columns + static_cast<std::size_t>(x);
        if (!(d < depth[at])) continue;
        depth[at] = d;
        samples[at] = {static_cast<float>(lit), facet_seen.empty() || (t < facet_seen.size() && facet_seen[t] != 0),
                       true};
      }
  }
  for (std::size_t y = 0; y < height_px; ++y)
    for (std::size_t x = 0; x < width_px; ++x) {
      double sum = 0.0;
      std::size_t hits = 0, seen = 0;
      for (std::size_t j = 0; j < kFine; ++j)
        for (std::size_t i = 0; i < kFine; ++i) {
          const Sample& s = samples[(y * kFine + j) * columns + x * kFine + i];
          if (!s.hit) continue;
          ++hits;
          seen += s.seen ? 1U : 0U;
          sum += static_cast<double>(s.light);
        }
      if (hits * 2 < kFine * kFine) continue;
      const double level = std::clamp(sum / static_cast<double>(hits), 0.0, 1.0) * (kLevels - 1);
      const std::size_t tint = 2 * seen >= hits ? 0 : 1;
      picture.image.pixels[y * width_px + x] =
          static_cast<std::uint8_t>(1 + tint * kLevels + static_cast<std::size_t>(std::lround(level)));
    }
  return picture;
}

}  // namespace cairn::report
