#include "surface/march.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/random.hpp"
#include "geometry/mass_properties.hpp"
#include "surface/mesh_checks.hpp"
#include "surface/poisson_grid.hpp"

namespace cairn::surface {
namespace {

using geometry::Vec3;

Lattice cube_lattice(std::int64_t count, double extent) {
  Lattice lattice;
  lattice.count = {count, count, count};
  lattice.step = 2.0 * extent / static_cast<double>(count - 1);
  lattice.origin = Vec3::Constant(-extent);
  return lattice;
}

Crossing linear(const std::vector<float>& values) {
  return [&values](std::size_t inner, std::size_t outer) {
    const double a = static_cast<double>(values[inner]), b = static_cast<double>(values[outer]);
    return a / (a - b);
  };
}

std::vector<float> sphere_values(const Lattice& lattice, double radius) {
  std::vector<float> values(lattice.size());
  for (std::size_t n = 0; n < values.size(); ++n) values[n] = static_cast<float>(lattice.node(n).norm() - radius);
  return values;
}

TEST(MarchTetrahedra, SphereToSecondOrder) {
  const double exact = 4.0 / 3.0 * std::numbers::pi * 0.512;
  double previous = 0.0;
  for (const std::int64_t count : {17, 33, 65}) {
    const auto lattice = cube_lattice(count, 1.0);
    const auto values = sphere_values(lattice, 0.8);
    const auto mesh = march_tetrahedra(lattice, values, linear(values));
    EXPECT_TRUE(geometry::topology(mesh).closed());
    const double error = 1.0 - geometry::mass_properties(mesh).volume / exact;
    EXPECT_GT(error, 0.0);  // chords lie inside
    if (previous > 0.0) {
      EXPECT_NEAR(previous / error, 4.0, 0.5);
    }
    previous = error;
  }
}

// Whatever the values: closed, outward, no facet through another.
TEST(MarchTetrahedra, AnyValuesGiveAnEmbeddedSurface) {
  base::Random random(3, "march", 0);
  for (int round = 0; round < 5; ++round) {
    const auto lattice = cube_lattice(9, 1.0);
    std::vector<float> values(lattice.size());
    for (std::size_t n = 0; n < values.size(); ++n) {
      const auto c = lattice.cell_of(n);
      bool rim = false;
      for (const auto i : c) rim = rim || i == 0 || i == 8;
      values[n] = rim ? 1.0F : static_cast<float>(random.normal());
    }
    const auto mesh = march_tetrahedra(lattice, values, linear(values));
    const auto topology = geometry::topology(mesh);
    EXPECT_TRUE(topology.closed());
    EXPECT_EQ(topology.degenerate_triangles, 0U);
    EXPECT_FALSE(self_intersects(mesh));
    EXPECT_GT(geometry::mass_properties(mesh).volume, 0.0);
  }
}

TEST(MarchTetrahedra, LargestPiece) {
  const auto lattice = cube_lattice(41, 1.0);
  std::vector<float> values(lattice.size());
  for (std::size_t n = 0; n < values.size(); ++n) {
    const Vec3 p = lattice.node(n);
    values[n] = static_cast<float>(std::min((p - Vec3(-0.4, 0, 0)).norm() - 0.4, (p - Vec3(0.6, 0, 0)).norm() - 0.2));
  }
  std::size_t dropped = 0;
  const auto mesh = largest_piece(march_tetrahedra(lattice, values, linear(values)), dropped);
  EXPECT_EQ(dropped, 1U);
  EXPECT_EQ(geometry::topology(mesh).components, 1U);
  EXPECT_NEAR(geometry::mass_properties(mesh).centre_of_mass.x(), -0.4, 1e-3);
}

// Indicator of a sphere sampled evenly: 1 inside, 0 outside.
TEST(PoissonGrid, IndicatorOfASphere) {
  Lattice lattice;
  lattice.step = 0.05;
  for (std::size_t a = 0; a < 3; ++a) {
    lattice.count[a] = poisson_count(3.0, lattice.step);
    lattice.origin[static_cast<Eigen::Index>(a)] = -0.5 * lattice.step * static_cast<double>(lattice.count[a] - 1);
  }
  constexpr int kCount = 20000;
  std::vector<Vec3> points, normals;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kCount, turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    normals.emplace_back(std::sqrt(1 - z * z) * std::cos(turn), std::sqrt(1 - z * z) * std::sin(turn), z);
    points.push_back(normals.back());
  }
  const std::vector<double> areas(kCount, 4.0 * std::numbers::pi / kCount);
  const auto values = solve_poisson(lattice, points, normals, areas);
  constexpr double kTolerance = 0.04;  // of the jump of 1, three cells from it
  for (const double r : {0.0, 0.3, 0.6, 0.85}) EXPECT_NEAR(interpolate(lattice, values, {r, 0, 0}), 1.0, kTolerance);
  for (const double r : {1.15, 1.3, 1.5}) EXPECT_NEAR(interpolate(lattice, values, {0, r, 0}), 0.0, kTolerance);
  double sum = 0.0;
  for (const auto& p : points) sum += interpolate(lattice, values, p);
  EXPECT_NEAR(sum / kCount, 0.5, kTolerance);
}

}  // namespace
}  // namespace cairn::surface
