#include "coverage/sight_lines.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

// Index of that vector (the first one of equals).
std::size_t farthest(Floats x, Floats y, Floats z, float px, float py, float pz) {
  const float best = farthest_distance(x, y, z, px, py, pz);
  for (std::size_t i = 0; i < x.size(); ++i) {
    const float dx = x[i] - px, dy = y[i] - py, dz = z[i] - pz;
    if (dx * dx + dy * dy + dz * dz >= best) return i;
  }
  return 0;
}

float squared_chord(Floats x, Floats y, Floats z, std::size_t a, std::size_t b) {
  const float dx = x[a] - x[b], dy = y[a] - y[b], dz = z[a] - z[b];
  return dx * dx + dy * dy + dz * dz;
}

double angle_of(Floats x, Floats y, Floats z, std::size_t a, std::size_t b) {
  const geometry::Vec3 p(static_cast<double>(x[a]), static_cast<double>(y[a]), static_cast<double>(z[a]));
  const geometry::Vec3 q(static_cast<double>(x[b]), static_cast<double>(y[b]), static_cast<double>(z[b]));
  // The chord keeps its digits where the angle is small.
  return 2.0 * std::asin(std::min(1.0, 0.5 * (p - q).norm()));
}

// The two longest chords seen so far.
struct LongestTwo {
  float first = -1.0F, second = -1.0F;
  std::size_t first_a = 0, first_b = 0, second_a = 0, second_b = 0;

  void take(float chord, std::size_t a, std::size_t b) {
    if (chord > first) {
      second = first;
      second_a = first_a;
      second_b = first_b;
      first = chord;
      first_a = a;
      first_b = b;
    } else if (chord > second) {
      second = chord;
      second_a = a;
      second_b = b;
    }
  }
};

}  // namespace

WidestAngles widest_angles(Floats x, Floats y, Floats z, SightLines& scratch) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (x.size() == 2) return {angle_of(x, y, z, 0, 1), kNone};
  // Two sweeps find a pair that is close to the farthest; the next chords from its ends are close to the second.
  const std::size_t a = farthest(x, y, z, x[0], y[0], z[0]);
  const std::size_t b = farthest(x, y, z, x[a], y[a], z[a]);
  const auto [low, high] = std::minmax(a, b);
  float bound = 0.0F;
  for (const auto& [begin, end] : {std::pair(std::size_t{0}, low), {low + 1, high}, {high + 1, x.size()}}) {
    if (begin >= end) continue;
    const Floats sx = x.subspan(begin, end - begin), sy = y.subspan(begin, end - begin),
                 sz = z.subspan(begin, end - begin);
    bound = std::max(
        {bound, farthest_distance(sx, sy, sz, x[a], y[a], z[a]), farthest_distance(sx, sy, sz, x[b], y[b], z[b])});
  }
  bound = std::min(bound, squared_chord(x, y, z, a, b));
  // Any two vectors are at most as far apart as their distances to the middle of a and b together, so a vector
  // takes part in a chord of the bound's length only if its own distance and the largest one reach it.
  const float mx = 0.5F * (x[a] + x[b]), my = 0.5F * (y[a] + y[b]), mz = 0.5F * (z[a] + z[b]);
  const float reach = std::sqrt(farthest_distance(x, y, z, mx, my, mz));
  constexpr float kSlack = 1.0F - 1e-5F;  // single precision
  const float least = std::max(0.0F, std::sqrt(bound) * kSlack - reach);
  scratch.clear();
  for (std::size_t i = 0; i < x.size(); ++i) {
    const float dx = x[i] - mx, dy = y[i] - my, dz = z[i] - mz;
    if (dx * dx + dy * dy + dz * dz < least * least) continue;
    scratch.x.push_back(x[i]);
    scratch.y.push_back(y[i]);
    scratch.z.push_back(z[i]);
  }
  const Floats cx(scratch.x), cy(scratch.y), cz(scratch.z);
  LongestTwo longest;
  for (std::size_t i = 0; i + 1 < cx.size(); ++i) {
    const Floats rx = cx.subspan(i + 1), ry = cy.subspan(i + 1), rz = cz.subspan(i + 1);
    const float competing = std::max(bound * kSlack * kSlack, longest.second);
    if (farthest_distance(rx, ry, rz, cx[i], cy[i], cz[i]) < competing) continue;
    for (std::size_t j = i + 1; j < cx.size(); ++j) longest.take(squared_chord(cx, cy, cz, i, j), i, j);
  }
  return {angle_of(cx, cy, cz, longest.first_a, longest.first_b),
          longest.second < 0.0F ? kNone : angle_of(cx, cy, cz, longest.second_a, longest.second_b)};
}

}  // namespace cairn::coverage
