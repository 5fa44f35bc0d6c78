// Rasters as pictures for the map, and as numbers for the read-out under the cursor.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/grid.hpp"
#include "report/png.hpp"
#include "report/report_data.hpp"

namespace cairn::report {

// Cells merged in blocks so that neither side is longer than max_px. How a block becomes one cell:
enum class Merge { mean, maximum };
[[nodiscard]] geometry::Grid<float> shrunk(const geometry::Grid<float>& grid, std::size_t max_px, Merge merge);

// Least and greatest finite value; empty where all cells are NaN.
struct ValueRange {
  double lo = 0.0, hi = 0.0;
};
[[nodiscard]] std::optional<ValueRange> value_range(const geometry::Grid<float>& grid);
// The same between two quantiles, 0 <= lo < hi <= 1 (nearest rank), so that outliers do not rule the colours.
[[nodiscard]] std::optional<ValueRange> quantile_range(const geometry::Grid<float>& grid, double lo, double hi);

// Shaded relief after Horn (1981): slopes from the eight neighbours, Lambert's cosine. A missing neighbour counts
// as the cell itself. No data is transparent.
[[nodiscard]] IndexedImage hillshade(const geometry::Grid<float>& heights, double sun_azimuth_deg,
                                     double sun_altitude_deg);
[[nodiscard]] IndexedImage height_tint(const geometry::Grid<float>& heights, const ValueRange& range);
// 0 views in vermilion, 1 .. max_views over cividis; more than max_views as max_views.
[[nodiscard]] IndexedImage view_counts(const geometry::Grid<float>& views, int max_views);
// Cost 0 is clear, then the cost ramp up to `top`; at or above `lethal` dark.
[[nodiscard]] IndexedImage cost_picture(const geometry::Grid<float>& cost, double top, std::optional<double> lethal);
[[nodiscard]] RgbaImage colour_picture(const ColourView& colours, std::size_t max_px);

// Little-endian 16-bit counts of `step` above `offset`, 65535 = no data; zlib, base64.
struct PackedGrid {
  geometry::GridGeometry geometry;
  double offset = 0.0, step = 1.0;
  std::string base64;
};
[[nodiscard]] PackedGrid packed(const geometry::Grid<float>& grid, std::size_t max_px, Merge merge);

}  // namespace cairn::report
