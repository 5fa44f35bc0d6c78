#include "geometry/grid_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn::geometry {
namespace {

constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

}  // namespace

GridMesh grid_mesh(const Grid<float>& heights) {
  const GridGeometry& g = heights.geometry;
  GridMesh result;
  if (g.cells() == 0) return result;
  const std::size_t row_vertices = g.columns + 1;
  std::vector<std::uint32_t> vertex(row_vertices * (g.rows + 1), kNoVertex);
  std::vector<double> up(vertex.size());
  std::size_t cells = 0;
  for (const float h : heights.values) cells += std::isfinite(h) ? 1U : 0U;
  result.mesh.vertices.reserve(cells + cells / 8 + row_vertices);
  for (std::size_t r = 0; r <= g.rows; ++r)
    for (std::size_t c = 0; c <= g.columns; ++c) {
      double sum = 0.0;
      int count = 0;
      for (std::size_t i = r - (r > 0 ? 1U : 0U); i <= std::min(r, g.rows - 1); ++i)
        for (std::size_t j = c - (c > 0 ? 1U : 0U); j <= std::min(c, g.columns - 1); ++j)
          if (const float h = heights.at(i, j); std::isfinite(h)) {
            sum += static_cast<double>(h);
            ++count;
          }
      if (count == 0) continue;
      const std::size_t k = r * row_vertices + c;
      up[k] = sum / count;
      vertex[k] = static_cast<std::uint32_t>(result.mesh.vertices.size());
      result.mesh.vertices.emplace_back(g.west + g.cell * static_cast<double>(c),
                                        g.north - g.cell * static_cast<double>(r), up[k]);
    }
  result.mesh.triangles.reserve(2 * cells);
  result.facet_cell.reserve(2 * cells);
  for (std::size_t r = 0; r < g.rows; ++r)
    for (std::size_t c = 0; c < g.columns; ++c) {
      if (!std::isfinite(heights.at(r, c))) continue;
      const std::size_t nw = r * row_vertices + c, ne = nw + 1, sw = nw + row_vertices, se = sw + 1;
      const auto add = [&](std::size_t a, std::size_t b, std::size_t d) {
        result.mesh.triangles.push_back({vertex[a], vertex[b], vertex[d]});
        result.facet_cell.push_back(static_cast<std::uint32_t>(r * g.columns + c));
      };
      if (std::abs(up[nw] - up[se]) <= std::abs(up[ne] - up[sw])) {
        add(nw, sw, se);
        add(nw, se, ne);
      } else {
        add(nw, sw, ne);
        add(sw, se, ne);
      }
    }
  return result;
}

}  // namespace cairn::geometry
