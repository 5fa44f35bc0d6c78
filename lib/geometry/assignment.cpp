#include "geometry/assignment.hpp"

#include <limits>

namespace cairn::geometry {
namespace {

// Requires rows <= columns. Index 0 of the work arrays is the free column.
std::vector<std::size_t> assign_wide(const std::vector<double>& cost, std::size_t rows, std::size_t columns) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<double> row_potential(rows + 1, 0.0), column_potential(columns + 1, 0.0);
  std::vector<std::size_t> row_of(columns + 1, 0), previous(columns + 1, 0);
  for (std::size_t row = 1; row <= rows; ++row) {
    row_of[0] = row;
    std::size_t column = 0;
    std::vector<double> slack(columns + 1, kInfinity);
    std::vector<bool> visited(columns + 1, false);
    do {
      visited[column] = true;
      const std::size_t r = row_of[column];
      double delta = kInfinity;
      std::size_t next = 0;
      for (std::size_t c = 1; c <= columns; ++c) {
        if (visited[c]) continue;
        const double reduced = cost[(r - 1) * columns + c - 1] - row_potential[r] - column_potential[c];
        if (reduced < slack[c]) {
          slack[c] = reduced;
          previous[c] = column;
        }
        if (slack[c] < delta) {
          delta = slack[c];
          next = c;
        }
      }
      for (std::size_t c = 0; c <= columns; ++c) {
        if (visited[c]) {
          row_potential[row_of[c]] += delta;
          column_potential[c] -= delta;
        } else {
          slack[c] -= delta;
        }
      }
      column = next;
    } while (row_of[column] != 0);
    do {
      const std::size_t before = previous[column];
      row_of[column] = row_of[before];
      column = before;
    } while (column != 0);
  }
  std::vector<std::size_t> result(rows, kUnassigned);
  for (std::size_t c = 1; c <= columns; ++c)
    if (row_of[c] != 0) result[row_of[c] - 1] = c - 1;
  return result;
}

}  // namespace

std::vector<std::size_t> assign(const std::vector<double>& cost, std::size_t rows, std::size_t columns) {
  if (rows == 0 || columns == 0) return std::vector<std::size_t>(rows, kUnassigned);
  if (rows <= columns) return assign_wide(cost, rows, columns);
  std::vector<double> transposed(cost.size());
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c) transposed[c * rows + r] = cost[r * columns + c];
  const auto row_of_column = assign_wide(transposed, columns, rows);
  std::vector<std::size_t> result(rows, kUnassigned);
  for (std::size_t c = 0; c < columns; ++c)
    if (row_of_column[c] != kUnassigned) result[row_of_column[c]] = c;
  return result;
}

}  // namespace cairn::geometry
