// Highest point, mean and count of 10 M points on a 10 cm grid, in one pass.
// usage: bench_cell_statistics terrain_xyz.f64   (x, y, z as doubles, 100 x 100 m)
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "bench/cpu_clock.hpp"
#include "segmentation/cell_statistics.hpp"

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  std::ifstream in(argv[1], std::ios::binary | std::ios::ate);
  std::vector<cairn::geometry::Vec3> points(static_cast<std::size_t>(in.tellg()) / sizeof(cairn::geometry::Vec3));
  in.seekg(0);
  in.read(reinterpret_cast<char*>(points.data()),
          static_cast<std::streamsize>(points.size() * sizeof(cairn::geometry::Vec3)));
  const cairn::geometry::GridGeometry grid{0.0, 100.0, 0.1, 1000, 1000};
  double best = 1e9;
  double check = 0.0;
  for (int i = 0; i < 5; ++i) {
    const double start = cairn::bench::cpu_seconds();
    const auto result = cairn::segmentation::cell_statistics(points, grid);
    best = std::min(best, cairn::bench::cpu_seconds() - start);
    check = 0.0;
    for (std::size_t k = 0; k < grid.cells(); ++k)
      if (result.count.values[k] > 0) check += static_cast<double>(result.max.values[k] + result.mean.values[k]);
  }
  std::printf("max, mean, count: %zu points, %.3f CPU s (best of 5), checksum %.3f, peak %.0f MB\n", points.size(),
              best, check, cairn::bench::peak_megabytes());
  return 0;
}
