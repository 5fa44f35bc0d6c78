// Costmap of a grid of obstacles: exact distance and cost.
// usage: bench_costmap GRID.u8 COLUMNS [check]   GRID.u8: row-major bytes, 0 = free, else an obstacle (gen_grid.py)
//        bench_costmap COLUMNS                   draws discs itself
// `check` compares with the lower envelope of parabolas over the whole grid, cell by cell.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>

#include "base/random.hpp"
#include "bench/cpu_clock.hpp"
#include "ground/costmap.hpp"
#include "ground/distance.hpp"

namespace {

using cairn::ground::Occupancy;
using cairn::ground::OccupancyGrid;

void draw_discs(OccupancyGrid& grid) {
  cairn::base::Random random(1, "bench", 0);
  const auto n = static_cast<std::int64_t>(grid.geometry.columns);
  for (std::int64_t disc = 0; disc < n * n / 20000; ++disc) {
    const auto radius = 5 + static_cast<std::int64_t>(random.below(56));
    const auto x = static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(n)));
    const auto y = static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(n)));
    for (std::int64_t r = std::max<std::int64_t>(0, y - radius); r < std::min(n, y + radius + 1); ++r)
      for (std::int64_t c = std::max<std::int64_t>(0, x - radius); c < std::min(n, x + radius + 1); ++c)
        if ((r - y) * (r - y) + (c - x) * (c - x) <= radius * radius)
          grid.at(static_cast<std::size_t>(r), static_cast<std::size_t>(c)) = Occupancy::occupied;
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const std::size_t n = std::stoul(argc > 2 ? argv[2] : argv[1]);
  OccupancyGrid grid({0.0, 0.0, 0.05, n, n}, Occupancy::free);
  if (argc > 2) {
    std::ifstream in(argv[1], std::ios::binary);
    in.read(reinterpret_cast<char*>(grid.values.data()), static_cast<std::streamsize>(grid.values.size()));
    if (!in) return 2;
    for (auto& v : grid.values) v = static_cast<int>(v) != 0 ? Occupancy::occupied : Occupancy::free;
  } else {
    draw_discs(grid);
  }
  const auto lethal = static_cast<double>(std::count(grid.values.begin(), grid.values.end(), Occupancy::occupied));
  const cairn::ground::CostmapOptions options;
  double best = 1e9, first = 0.0;
  std::uint64_t sum = 0;
  for (int i = 0; i < 3; ++i) {
    const double start = cairn::bench::cpu_seconds();
    const auto cost = cairn::ground::costmap(grid, options);
    const double seconds = cairn::bench::cpu_seconds() - start;
    if (i == 0) first = seconds;
    best = std::min(best, seconds);
    sum = 0;
    for (const auto v : cost.values) sum += v;
  }
  std::printf("%zu x %zu cells, %.1f %% lethal: %.3f CPU s first, %.3f best of 3, sum %llu, peak %.0f MB\n", n, n,
              100.0 * lethal / static_cast<double>(grid.values.size()), first, best,
              static_cast<unsigned long long>(sum), cairn::bench::peak_megabytes());
  if (argc > 3 && std::strcmp(argv[3], "check") == 0) {
    const auto cost = cairn::ground::costmap(grid, options);
    cairn::geometry::Grid<std::uint8_t> blocked(grid.geometry, 0);
    for (std::size_t i = 0; i < grid.values.size(); ++i)
      blocked.values[i] = grid.values[i] == Occupancy::occupied ? 1 : 0;
    const int reach = cairn::ground::reach_cells(options);
    const auto squared = cairn::ground::squared_distance(blocked, reach);
    std::size_t wrong = 0;
    for (std::size_t i = 0; i < grid.values.size(); ++i) {
      const int d2 = squared.values[i];
      const std::uint8_t expected =
          d2 > reach * reach ? 0 : cairn::ground::cost_at(std::sqrt(static_cast<double>(d2)) * 0.05, options);
      if (cost.values[i] != expected) ++wrong;
    }
    std::printf("%zu of %zu cells differ from the lower envelope\n", wrong, grid.values.size());
    return wrong == 0 ? 0 : 1;
  }
  return 0;
}
