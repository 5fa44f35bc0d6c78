// Optimal one-to-one assignment.
#pragma once

#include <cstddef>
#include <vector>

namespace cairn::geometry {

inline constexpr std::size_t kUnassigned = static_cast<std::size_t>(-1);

// Minimises the summed cost of assigning each row to a distinct column (Hungarian method with
// potentials, Kuhn 1955 / Jonker & Volgenant 1987). cost is row-major, rows x columns, finite.
// Result: column of each row, or kUnassigned for the rows left over when rows > columns.
// Cost O(min(r,c)^2 max(r,c)). Deterministic: ties go to the lower column.
[[nodiscard]] std::vector<std::size_t> assign(const std::vector<double>& cost, std::size_t rows, std::size_t columns);

}  // namespace cairn::geometry
