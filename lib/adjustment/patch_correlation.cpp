#include "adjustment/patch_correlation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace cairn::adjustment {
namespace {

constexpr double kLeastFilled = 0.8;  // share of the patch's cells that must have values
constexpr double kLeastSigma = 0.5;   // grey levels: less contrast is compression noise

// Correlation with the patch's first cell on (row, column) of the window; -1 where it is not defined.
double score_at(const Window& patch, const Window& window, std::size_t row, std::size_t column) {
  double n = 0, sp = 0, sw = 0, spp = 0, sww = 0, spw = 0;
  for (std::size_t r = 0; r < patch.side; ++r) {
    const float* p = &patch.values[r * patch.side];
    const float* w = &window.values[(row + r) * window.side + column];
    float rn = 0, rp = 0, rw = 0, rpp = 0, rww = 0, rpw = 0;
    for (std::size_t c = 0; c < patch.side; ++c) {
      const float product = p[c] * w[c];
      if (std::isnan(product)) continue;
      rn += 1.0F;
      rp += p[c];
      rw += w[c];
      rpp += p[c] * p[c];
      rww += w[c] * w[c];
      rpw += product;
    }
    n += static_cast<double>(rn);
    sp += static_cast<double>(rp);
    sw += static_cast<double>(rw);
    spp += static_cast<double>(rpp);
    sww += static_cast<double>(rww);
    spw += static_cast<double>(rpw);
  }
  if (n < kLeastFilled * static_cast<double>(patch.side * patch.side)) return -1.0;
  const double vp = spp / n - sp * sp / (n * n), vw = sww / n - sw * sw / (n * n);
  if (vp < kLeastSigma * kLeastSigma || vw < kLeastSigma * kLeastSigma) return -1.0;
  return (spw / n - sp * sw / (n * n)) / std::sqrt(vp * vw);
}

// Top of the least-squares quadric through 3 x 3 scores, within half a cell; scores[4] is the middle.
// Both axes at once: slanted patterns couple them.
geometry::Vec2 vertex(const std::array<double, 9>& s) {
  const double gx = (s[2] + s[5] + s[8] - s[0] - s[3] - s[6]) / 6.0;
  const double gy = (s[6] + s[7] + s[8] - s[0] - s[1] - s[2]) / 6.0;
  const double xx = (s[0] + s[2] + s[3] + s[5] + s[6] + s[8] - 2.0 * (s[1] + s[4] + s[7])) / 3.0;
  const double yy = (s[0] + s[1] + s[2] + s[6] + s[7] + s[8] - 2.0 * (s[3] + s[4] + s[5])) / 3.0;
  const double xy = (s[0] + s[8] - s[2] - s[6]) / 4.0;
  const double det = xx * yy - xy * xy;
  if (!(det > 0.0 && xx < 0.0)) return geometry::Vec2::Zero();
  const geometry::Vec2 top((xy * gy - yy * gx) / det, (xy * gx - xx * gy) / det);
  return top.cwiseMax(-0.5).cwiseMin(0.5);
}

}  // namespace

std::optional<PatchPeak> correlate(const Window& patch, const Window& window) {
  if (patch.side == 0 || window.side < patch.side + 2) return std::nullopt;
  const std::size_t steps = window.side - patch.side + 1;
  std::vector<double> scores(steps * steps);
  for (std::size_t r = 0; r < steps; ++r)
    for (std::size_t c = 0; c < steps; ++c) scores[r * steps + c] = score_at(patch, window, r, c);
  const auto best = static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  const std::size_t row = best / steps, column = best % steps;
  if (scores[best] <= 0.0 || row == 0 || column == 0 || row + 1 == steps || column + 1 == steps) return std::nullopt;
  const double centre = 0.5 * static_cast<double>(steps - 1);
  PatchPeak peak;
  peak.correlation = scores[best];
  std::array<double, 9> around{};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c) around[3 * r + c] = scores[(row + r - 1) * steps + column + c - 1];
  const geometry::Vec2 top = vertex(around);
  // The window's content at (row, column) is the patch's: the patch lies `centre - position` from it.
  peak.shift_cells = {centre - (static_cast<double>(column) + top.x()), centre - (static_cast<double>(row) + top.y())};
  return peak;
}

}  // namespace cairn::adjustment
