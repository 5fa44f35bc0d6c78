#include "surface/poisson_grid.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace cairn::surface {
namespace {

using geometry::Vec3;

constexpr std::int64_t kCoarsening = 16;  // 2^4: five levels

struct Level {
  std::array<std::int64_t, 3> n{};
  std::vector<float> x, b, r;

  explicit Level(const std::array<std::int64_t, 3>& count) : n(count) {
    const auto size = static_cast<std::size_t>(n[0] * n[1] * n[2]);
    x.assign(size, 0.0F);
    b.assign(size, 0.0F);
    r.assign(size, 0.0F);
  }
  [[nodiscard]] std::size_t at(std::int64_t i, std::int64_t j, std::int64_t k) const {
    return static_cast<std::size_t>((k * n[1] + j) * n[0] + i);
  }
};

// Slices of inner nodes, at once.
void each_inner_slice(const Level& level, const std::function<void(std::int64_t)>& visit) {
  base::parallel_for(static_cast<std::size_t>(level.n[2] - 2), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) visit(static_cast<std::int64_t>(k) + 1);
  });
}

// Red-black Gauss-Seidel for 6 x - sum of neighbours = b.
void relax(Level& level, int sweeps) {
  const auto nx = static_cast<std::size_t>(level.n[0]), plane = nx * static_cast<std::size_t>(level.n[1]);
  for (int half = 0; half < 2 * sweeps; ++half)
    each_inner_slice(level, [&](std::int64_t k) {
      for (std::int64_t j = 1; j + 1 < level.n[1]; ++j) {
        const std::int64_t first = 1 + ((j + k + half + 1) & 1);
        std::size_t c = level.at(first, j, k);
        for (std::int64_t i = first; i + 1 < level.n[0]; i += 2, c += 2)
          level.x[c] = (level.x[c - 1] + level.x[c + 1] + level.x[c - nx] + level.x[c + nx] + level.x[c - plane] +
                        level.x[c + plane] + level.b[c]) *
                       (1.0F / 6.0F);
      }
    });
}

void residual(Level& level) {
  const auto nx = static_cast<std::size_t>(level.n[0]), plane = nx * static_cast<std::size_t>(level.n[1]);
  each_inner_slice(level, [&](std::int64_t k) {
    for (std::int64_t j = 1; j + 1 < level.n[1]; ++j) {
      std::size_t c = level.at(1, j, k);
      for (std::int64_t i = 1; i + 1 < level.n[0]; ++i, ++c)
        level.r[c] = level.b[c] - 6.0F * level.x[c] + level.x[c - 1] + level.x[c + 1] + level.x[c - nx] +
                     level.x[c + nx] + level.x[c - plane] + level.x[c + plane];
    }
  });
}

constexpr std::array<float, 3> kSpread{0.5F, 1.0F, 0.5F};

void restrict_to(const Level& fine, Level& coarse) {
  std::fill(coarse.x.begin(), coarse.x.end(), 0.0F);
  each_inner_slice(coarse, [&](std::int64_t k) {
    for (std::int64_t j = 1; j + 1 < coarse.n[1]; ++j)
      for (std::int64_t i = 1; i + 1 < coarse.n[0]; ++i) {
        float sum = 0.0F;
        for (int c = 0; c < 3; ++c)
          for (int b = 0; b < 3; ++b)
            for (int a = 0; a < 3; ++a)
              sum += kSpread[static_cast<std::size_t>(a)] * kSpread[static_cast<std::size_t>(b)] *
                     kSpread[static_cast<std::size_t>(c)] *
                     fine.r[fine.at(2 * i + a - 1, 2 * j + b - 1, 2 * k + c - 1)];
        // Full weighting is sum / 8; the equations of the coarse level have a step twice as long.
        coarse.b[coarse.at(i, j, k)] = 0.5F * sum;
      }
  });
}

void prolong_from(const Level& coarse, Level& fine) {
  each_inner_slice(fine, [&](std::int64_t k) {
    for (std::int64_t j = 1; j + 1 < fine.n[1]; ++j)
      for (std::int64_t i = 1; i + 1 < fine.n[0]; ++i) {
        const std::int64_t ci = i / 2, cj = j / 2, ck = k / 2;
        float sum = 0.0F;
        for (std::int64_t c = 0; c <= (k & 1); ++c)
          for (std::int64_t b = 0; b <= (j & 1); ++b)
            for (std::int64_t a = 0; a <= (i & 1); ++a) sum += coarse.x[coarse.at(ci + a, cj + b, ck + c)];
        fine.x[fine.at(i, j, k)] += sum / static_cast<float>((1 + (i & 1)) * (1 + (j & 1)) * (1 + (k & 1)));
      }
  });
}

void v_cycle(std::vector<Level>& levels, std::size_t at) {
  if (at + 1 == levels.size()) {
    relax(levels[at], 60);
    return;
  }
  relax(levels[at], 2);
  residual(levels[at]);
  restrict_to(levels[at], levels[at + 1]);
  v_cycle(levels, at + 1);
  prolong_from(levels[at + 1], levels[at]);
  relax(levels[at], 2);
}

struct Corner {
  std::array<std::int64_t, 3> low{};
  std::array<double, 3> f{};
};

Corner corner_of(const Lattice& lattice, const Vec3& position) {
  Corner c;
  for (int a = 0; a < 3; ++a) {
    const auto s = static_cast<std::size_t>(a);
    const double q = (position[a] - lattice.origin[a]) / lattice.step;
    c.low[s] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(q)), 0, lattice.count[s] - 2);
    c.f[s] = std::clamp(q - static_cast<double>(c.low[s]), 0.0, 1.0);
  }
  return c;
}

}  // namespace

std::int64_t poisson_count(double extent, double step) {
  const auto cells = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(extent / step)));
  return (cells + kCoarsening - 1) / kCoarsening * kCoarsening + 1;
}

std::vector<float> solve_poisson(const Lattice& lattice, std::span<const Vec3> points, std::span<const Vec3> normals,
                                 std::span<const double> areas) {
  std::vector<Level> levels;
  levels.emplace_back(lattice.count);
  for (std::int64_t c = 2; c <= kCoarsening; c *= 2)
    levels.emplace_back(std::array<std::int64_t, 3>{(lattice.count[0] - 1) / c + 1, (lattice.count[1] - 1) / c + 1,
                                                    (lattice.count[2] - 1) / c + 1});
  auto& fine = levels.front();
  // Right side: area x (-normal) . gradient of the node's trilinear element; the stiffness of the 7-point Laplacian
  // with step h is h times its stencil.
  const double h = lattice.step;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto c = corner_of(lattice, points[i]);
    const Vec3 flux = -areas[i] / (h * h) * normals[i];
    for (int corner = 0; corner < 8; ++corner) {
      std::array<double, 3> w{}, g{};
      std::array<std::int64_t, 3> at{};
      for (std::size_t a = 0; a < 3; ++a) {
        const bool upper = ((corner >> a) & 1) != 0;
        at[a] = c.low[a] + (upper ? 1 : 0);
        w[a] = upper ? c.f[a] : 1.0 - c.f[a];
        g[a] = upper ? 1.0 : -1.0;
      }
      fine.b[fine.at(at[0], at[1], at[2])] += static_cast<float>(
          flux.x() * g[0] * w[1] * w[2] + flux.y() * w[0] * g[1] * w[2] + flux.z() * w[0] * w[1] * g[2]);
    }
  }
  constexpr int kCycles = 8;  // residual / 5 or more each
  for (int i = 0; i < kCycles; ++i) v_cycle(levels, 0);
  return std::move(fine.x);
}

double interpolate(const Lattice& lattice, std::span<const float> values, const Vec3& position) {
  const auto c = corner_of(lattice, position);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    double w = 1.0;
    std::array<std::int64_t, 3> at{};
    for (std::size_t a = 0; a < 3; ++a) {
      const bool upper = ((corner >> a) & 1) != 0;
      at[a] = c.low[a] + (upper ? 1 : 0);
      w *= upper ? c.f[a] : 1.0 - c.f[a];
    }
    sum += w * static_cast<double>(values[lattice.index(at[0], at[1], at[2])]);
  }
  return sum;
}

}  // namespace cairn::surface
