// Shortest and least-cost paths over grids of 4096 x 4096 cells, 0 free and 254 blocked.
// usage: bench_route GRID.u8 [WEIGHT]   (row-major bytes; with a weight the grid is inflated first, equation (9) in
// cells)
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "bench/cpu_clock.hpp"
#include "ground/costmap.hpp"
#include "ground/route.hpp"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  std::ifstream in(argv[1], std::ios::binary | std::ios::ate);
  const auto bytes = static_cast<std::size_t>(in.tellg());
  const auto side = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(bytes))));
  cairn::geometry::Grid<std::uint8_t> cost({0.0, static_cast<double>(side), 1.0, side, side}, 0);
  in.seekg(0);
  in.read(reinterpret_cast<char*>(cost.values.data()), static_cast<std::streamsize>(cost.values.size()));
  cairn::ground::RouteOptions options;
  options.cost_weight = argc > 2 ? std::atof(argv[2]) : 0.0;
  if (argc > 2) {
    cairn::ground::OccupancyGrid occupancy(cost.geometry, cairn::ground::Occupancy::free);
    for (std::size_t i = 0; i < cost.values.size(); ++i)
      if (cost.values[i] != 0) occupancy.values[i] = cairn::ground::Occupancy::occupied;
    // 0.05 m a cell: R = 0.1 m, alpha = 3 / m.
    cost = cairn::ground::costmap(occupancy, {2.0, 0.15, 1.0});
  }
  // The first free cells of the diagonal from either end.
  cairn::ground::Cell start{0, 0}, goal{side - 1, side - 1};
  while (start.first < side && cost.at(start.first, start.second) >= 253) start = {start.first + 1, start.first + 1};
  while (goal.first > 0 && cost.at(goal.first, goal.second) >= 253) goal = {goal.first - 1, goal.first - 1};
  double best = 1e9;
  cairn::ground::Route route;
  for (int i = 0; i < 5; ++i) {
    cairn::base::RunContext ctx;
    const double before = cairn::bench::cpu_seconds();
    route = cairn::ground::find_route(cost, start, goal, options, ctx);
    best = std::min(best, cairn::bench::cpu_seconds() - before);
  }
  std::printf("%s, length %.2f, weighted %.2f, expansions %llu, %.3f CPU s (best of 5), peak %.0f MB\n",
              route.found ? "found" : route.reason.c_str(), route.length_m, route.weighted_length_m,
              static_cast<unsigned long long>(route.expansions), best, cairn::bench::peak_megabytes());
  return 0;
}
