#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "simulation/noise.hpp"
#include "simulation/resting_body.hpp"

namespace cairn::simulation {
namespace {

using geometry::TriangleMesh;
using geometry::Vec3;

constexpr double kTurn = 2.0 * std::numbers::pi;

Ring3 circle(std::size_t sectors, const Vec3& centre, double radius) {
  Ring3 ring(sectors);
  for (std::size_t i = 0; i < sectors; ++i) {
    const double a = kTurn * static_cast<double>(i) / static_cast<double>(sectors);
    ring[i] = centre + radius * Vec3(std::cos(a), std::sin(a), 0.0);
  }
  return ring;
}

// A ball of foliage: strong relief at the scale of twigs.
TriangleMesh foliage(const Vec3& centre, const Vec3& radii, double relief, std::size_t sectors, std::uint64_t seed) {
  const auto surface = [&](double polar, double azimuth) {
    const Vec3 u(std::sin(polar) * std::cos(azimuth), std::sin(polar) * std::sin(azimuth), std::cos(polar));
    const double r = 1.0 + relief * fractal_noise(4.0 * u + centre, seed, 4, 0.65);
    return Vec3(centre + r * u.cwiseProduct(radii));
  };
  std::vector<Ring3> rings;
  const std::size_t count = sectors / 2;
  for (std::size_t k = 1; k < count; ++k) {
    Ring3 ring(sectors);
    for (std::size_t i = 0; i < sectors; ++i)
      ring[i] = surface(std::numbers::pi * static_cast<double>(k) / static_cast<double>(count),
                        kTurn * static_cast<double>(i) / static_cast<double>(sectors));
    rings.push_back(std::move(ring));
  }
  return ring_mesh(surface(0.0, 0.0), rings, surface(std::numbers::pi, 0.0));
}

// A tier of a conifer: a skirt with a jagged hem.
TriangleMesh tier(double bottom, double top, double radius, double relief, std::size_t sectors, std::uint64_t seed) {
  std::vector<Ring3> rings;
  constexpr int kRings = 6;
  for (int k = 1; k <= kRings; ++k) {
    const double t = static_cast<double>(k) / kRings;
    Ring3 ring(sectors);
    for (std::size_t i = 0; i < sectors; ++i) {
      const double a = kTurn * static_cast<double>(i) / static_cast<double>(sectors);
      const double jag = fractal_noise({5.0 * std::cos(a), 5.0 * std::sin(a), 3.0 * t}, seed, 3, 0.6);
      const double r = radius * t * (1.0 + 1.2 * relief * jag * t);
      ring[i] = {r * std::cos(a), r * std::sin(a), top + (bottom - top) * t * (1.0 + 0.25 * relief * jag)};
    }
    rings.push_back(std::move(ring));
  }
  return ring_mesh({0.0, 0.0, top}, rings, {0.0, 0.0, bottom + 0.35 * (top - bottom)});
}

TriangleMesh painted(TriangleMesh mesh, std::array<std::uint8_t, 3> colour) {
  mesh.colours.assign(mesh.vertices.size(), colour);
  return mesh;
}

constexpr std::array<std::uint8_t, 3> kBark = {104, 84, 66};

// Greens of one tree differ a little from branch to branch.
std::array<std::uint8_t, 3> leaf(std::string_view family, double shade) {
  const std::array<double, 3> base = family == "conifer" ? std::array<double, 3>{74.0, 88.0, 66.0}
                                     : family == "bush"  ? std::array<double, 3>{118.0, 118.0, 84.0}
                                                         : std::array<double, 3>{96.0, 108.0, 72.0};
  std::array<std::uint8_t, 3> colour{};
  for (std::size_t i = 0; i < 3; ++i) colour[i] = static_cast<std::uint8_t>(base[i] * (0.85 + 0.3 * shade));
  return colour;
}

}  // namespace

RestingBody make_tree(const ShapeSpec& spec, double edge, base::Random& random) {
  RestingBody tree;
  tree.family = spec.family.empty() ? tree_families()[random.below(tree_families().size())] : spec.family;
  const double around = std::numbers::pi * 0.5 * (spec.size_m.x() + spec.size_m.y());
  const auto sectors = static_cast<std::size_t>(4.0 * std::clamp(std::ceil(around / edge / 4.0), 4.0, 200.0));
  const double relief = 0.15 + 0.4 * spec.irregularity;
  // Built one unit high and about one across; the trunk first.
  const double crown_base = tree.family == "bush" ? 0.05 : tree.family == "conifer" ? 0.12 : random.uniform(0.25, 0.38);
  const double girth = tree.family == "bush" ? 0.05 : 0.035;
  append(tree.body,
         painted(ring_mesh({0.0, 0.0, 0.75},
                           {circle(12, {0.0, 0.0, 0.74}, 0.3 * girth), circle(12, {0.0, 0.0, crown_base}, 0.8 * girth),
                            circle(12, {0.0, 0.0, 0.0}, 1.4 * girth)},
                           Vec3::Zero()),
                 kBark));
  if (tree.family == "conifer") {
    constexpr int kTiers = 6;
    for (int k = 0; k < kTiers; ++k) {
      const double t = static_cast<double>(k) / kTiers, bottom = crown_base + (1.0 - crown_base) * t * 0.95;
      const double top = std::min(1.0, bottom + 0.34 * (1.0 - 0.55 * t));
      const std::uint64_t seed = random.bits();
      const auto green = leaf(tree.family, random.uniform());
      append(tree.body, painted(tier(bottom, top, 0.5 * (1.0 - 0.85 * t), relief, sectors, seed), green));
    }
  } else {
    const bool bush = tree.family == "bush";
    const int blobs = bush ? 5 : 7;
    const double middle = 0.5 * (1.0 + crown_base), half = 0.5 * (1.0 - crown_base);
    const std::uint64_t core_seed = random.bits();
    const auto core_green = leaf(tree.family, random.uniform());
    append(tree.body,
           painted(foliage({0.0, 0.0, middle}, Vec3(0.36, 0.36, 0.85 * half), relief, sectors, core_seed), core_green));
    for (int k = 0; k < blobs; ++k) {
      const double a = kTurn * (k + random.uniform(0.0, 0.6)) / blobs;
      const double out = random.uniform(0.18, 0.28), r = random.uniform(0.17, 0.25);
      const Vec3 centre(out * std::cos(a), out * std::sin(a), middle + random.uniform(-0.45, 0.45) * half);
      const std::uint64_t seed = random.bits();
      const auto green = leaf(tree.family, random.uniform());
      append(tree.body, painted(foliage(centre, Vec3(r, r, std::min(r, 0.8 * half)), relief, sectors, seed), green));
    }
  }
  // No crown reaches below the foot of the trunk.
  for (Vec3& v : tree.body.vertices) v.z() = std::max(v.z(), 0.0);
  const Vec3 scale = stretch_to(tree.body, spec.size_m);
  for (Vec3& v : tree.body.vertices) v = v.cwiseProduct(scale);
  const Ring3 under = circle(32, Vec3::Zero(), 0.1 * spec.size_m.x());
  tree.sectors = under.size();
  tree.seat = [under](std::size_t i, double factor) { return Vec3(factor * under[i]); };
  return tree;
}

}  // namespace cairn::simulation
