#include "coverage/sight_lines.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cairn::coverage {
namespace {

using Floats = std::span<const float>;
using Column = Eigen::Map<const Eigen::ArrayXf>;

// Squared distance of the vector farthest from (px, py, pz). Eigen works on four at once.
float farthest_distance(Floats x, Floats y, Floats z, float px, float py, float pz) {
  const auto n = static_cast<Eigen::Index>(x.size());
  return ((Column(x.data(), n) - px).square() + (Column(y.data(), n) - py).square() +
          (Column(z.data(), n) - pz).square())
      .maxCoeff();
}

// The same with its index (the first one of equals).
std::pair<std::size_t, float> farthest(Floats x, Floats y, Floats z, float px, float py, float pz) {
  const float best = farthest_distance(x, y, z, px, py, pz);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const float dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    if (dx * dx + dy * dy + dz * dz >= best) return {i, best};
  }
  return {0, best};
}

double angle_of(Floats x, Floats y, Floats z, std::size_t a, std::size_t b) {
  const geometry::Vec3 p(static_cast<double>(x[a]), static_cast<double>(y[a]), static_cast<double>(z[a]));
  const geometry::Vec3 q(static_cast<double>(x[b]), static_cast<double>(y[b]), static_cast<double>(z[b]));
  // The chord keeps its digits where the angle is small.
  return 2.0 * std::asin(std::min(1.0, 0.5 * (p - q).norm()));
}

}  // namespace

double largest_angle(Floats x, Floats y, Floats z, SightLines& scratch) {
  // Two sweeps find a pair that is close to the farthest.
  std::size_t a = farthest(x, y, z, x[0], y[0], z[0]).first;
  auto [b, best] = farthest(x, y, z, x[a], y[a], z[a]);
  // Any two vectors are at most as far apart as their distances to the middle of a and b together, so a vector
  // takes part in a longer pair only if its own distance and the largest one pass the best chord.
  const float mx = 0.5F * (x[a] + x[b]), my = 0.5F * (y[a] + y[b]), mz = 0.5F * (z[a] + z[b]);
  const float reach = std::sqrt(farthest_distance(x, y, z, mx, my, mz));
  constexpr float kSlack = 1.0F - 1e-5F;  // single precision
  const float least = std::max(0.0F, std::sqrt(best) * kSlack - reach);
  scratch.clear();
  for (std::size_t i = 0; i < x.size(); ++i) {
    const float dx = x[i] - mx, dy = y[i] - my, dz = z[i] - mz;
    if (dx * dx + dy * dy + dz * dz < least * least) continue;
    scratch.x.push_back(x[i]);
    scratch.y.push_back(y[i]);
    scratch.z.push_back(z[i]);
  }
  const Floats cx(scratch.x), cy(scratch.y), cz(scratch.z);
  double angle = angle_of(x, y, z, a, b);
  for (std::size_t i = 0; i + 1 < cx.size(); ++i) {
    const Floats rx = cx.subspan(i + 1), ry = cy.subspan(i + 1), rz = cz.subspan(i + 1);
    if (!(farthest_distance(rx, ry, rz, cx[i], cy[i], cz[i]) > best)) continue;
    const auto [j, chord] = farthest(rx, ry, rz, cx[i], cy[i], cz[i]);
    best = chord;
    angle = angle_of(cx, cy, cz, i, i + 1 + j);
  }
  return angle;
}

}  // namespace cairn::coverage
