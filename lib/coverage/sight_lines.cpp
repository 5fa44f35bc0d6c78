#include "coverage/sight_lines.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cairn::coverage {
namespace {

using Floats = std::span<const float>;

// Index and squared distance of the vector farthest from (px, py, pz).
std::pair<std::size_t, float> farthest(Floats x, Floats y, Floats z, float px, float py, float pz) {
  float best = -1.0F;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const float dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    best = std::max(best, dx * dx + dy * dy + dz * dz);
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    const float dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    if (dx * dx + dy * dy + dz * dz >= best) return {i, best};
  }
  return {0, best};
}

}  // namespace

double largest_angle(Floats x, Floats y, Floats z, SightLines& scratch) {
  const std::size_t n = x.size();
  // The chord grows with the angle, and keeps its digits where the angle is small.
  std::size_t a = farthest(x, y, z, x[0], y[0], z[0]).first;
  auto [b, best] = farthest(x, y, z, x[a], y[a], z[a]);
  if (n > 3) {
    // Any two vectors are at most as far apart as their distances to the middle of a and b together, so a vector
    // takes part in a longer pair only if its own distance and the largest one pass the best chord.
    const float mx = 0.5F * (x[a] + x[b]), my = 0.5F * (y[a] + y[b]), mz = 0.5F * (z[a] + z[b]);
    const float reach = std::sqrt(farthest(x, y, z, mx, my, mz).second);
    constexpr float kSlack = 1.0F - 1e-5F;  // single precision
    const float least = std::max(0.0F, std::sqrt(best) * kSlack - reach);
    scratch.clear();
    for (std::size_t i = 0; i < n; ++i) {
      const float dx = x[i] - mx, dy = y[i] - my, dz = z[i] - mz;
      if (dx * dx + dy * dy + dz * dz < least * least) continue;
      scratch.x.push_back(x[i]);
      scratch.y.push_back(y[i]);
      scratch.z.push_back(z[i]);
    }
    const Floats cx(scratch.x), cy(scratch.y), cz(scratch.z);
    std::size_t ca = 0, cb = 0;
    float longest = -1.0F;
    for (std::size_t i = 0; i + 1 < cx.size(); ++i) {
      const std::size_t next = i + 1;
      const auto [j, chord] = farthest(cx.subspan(next), cy.subspan(next), cz.subspan(next), cx[i], cy[i], cz[i]);
      if (chord > longest) {
        longest = chord;
        ca = i;
        cb = next + j;
      }
    }
    if (longest >= 0.0F) {
      const geometry::Vec3 p(static_cast<double>(cx[ca]), static_cast<double>(cy[ca]), static_cast<double>(cz[ca]));
      const geometry::Vec3 q(static_cast<double>(cx[cb]), static_cast<double>(cy[cb]), static_cast<double>(cz[cb]));
      return 2.0 * std::asin(std::min(1.0, 0.5 * (p - q).norm()));
    }
  }
  const geometry::Vec3 p(static_cast<double>(x[a]), static_cast<double>(y[a]), static_cast<double>(z[a]));
  const geometry::Vec3 q(static_cast<double>(x[b]), static_cast<double>(y[b]), static_cast<double>(z[b]));
  return 2.0 * std::asin(std::min(1.0, 0.5 * (p - q).norm()));
}

}  // namespace cairn::coverage
