// Grid maps and path-finding scenarios of the Moving AI benchmarks (Sturtevant 2012): .map and .scen.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "geometry/grid.hpp"

namespace cairn::io {

// Ground as its character: '.' and 'G' free, 'S' swamp (free), 'W' water, 'T' trees, '@' and 'O' out of bounds. Row 0
// is the first line of the file; cells of 1 m, so that lengths are in cells. Throws not_found, or invalid_input with
// the line: a type other than octile, a height or width missing, out of range or not the number of lines and characters
// there are, an unknown character. Cost linear in bytes.
[[nodiscard]] geometry::Grid<char> read_octile_map(const std::filesystem::path& path);

// Whether a character is ground that a walker on '.' can step on.
[[nodiscard]] bool is_free_terrain(char terrain);

struct ScenarioQuery {
  std::uint64_t line = 0;  // in the file, from 1
  std::int64_t bucket = 0;
  std::pair<std::size_t, std::size_t> start, goal;  // row, column
  double optimal = 0.0;                             // published length in cells, 6 digits
};

// The queries of a scenario file of version 1. All must be of a map with the given number of rows and columns (scaled
// maps are not made here) and lie on it. Throws not_found, or invalid_input with the line.
[[nodiscard]] std::vector<ScenarioQuery> read_scenario(const std::filesystem::path& path, std::size_t rows,
                                                       std::size_t columns);

}  // namespace cairn::io
