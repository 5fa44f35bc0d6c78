#include "pipeline/terrain_height.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "io/raster.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Grid;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kMostGrowth = 3.0;  // cells of the resampled raster over those of the file
constexpr double kReach = 2.0;       // m; how far an empty cell may borrow a height

const Grid<float>& ground_band(const io::Raster& raster, const std::filesystem::path& path) {
  const Grid<float>* only = nullptr;
  for (const auto& band : raster.bands) {
    const auto* values = std::get_if<Grid<float>>(&band.values);
    if (values == nullptr) continue;
    if (band.name == "ground") return *values;
    if (only == nullptr) only = values;
  }
  if (only == nullptr)
    throw base::Error(base::ErrorCode::invalid_input, "the raster has no band of heights").file(path.string());
  return *only;
}

// Whether the raster's coordinates are the local ones, as `cairn run` writes it. Measured, because many national grids
// are transverse Mercators too.
bool is_local(const geodesy::CrsConverter& converter) {
  constexpr double kSame = 1e-3;  // m, half a kilometre from the origin
  for (const Vec3& p : {Vec3(0.0, 0.0, 0.0), Vec3(400.0, -300.0, 0.0)})
    if (!((converter.from_local(p) - p).head<2>().norm() < kSame)) return false;
  return true;
}

Grid<float> to_up(Grid<float> heights, const geodesy::LocalFrame& frame) {
  const auto& g = heights.geometry;
  for (std::size_t r = 0; r < g.rows; ++r)
    for (std::size_t c = 0; c < g.columns; ++c) {
      float& value = heights.at(r, c);
      if (!std::isfinite(value)) continue;
      const Vec2 at = g.centre(r, c);
      value = static_cast<float>(static_cast<double>(value) - frame.to_geodetic(Vec3(at.x(), at.y(), 0.0)).height_m);
    }
  return heights;
}

// Bilinear between cell centres; the nearest of the four where one is not known. NaN outside.
float sample(const Grid<float>& grid, const Vec2& p) {
  const auto& g = grid.geometry;
  const double x = (p.x() - g.west) / g.cell - 0.5, y = (g.north - p.y()) / g.cell - 0.5;
  if (!(x >= -0.5 && y >= -0.5 && x <= static_cast<double>(g.columns) - 0.5 && y <= static_cast<double>(g.rows) - 0.5))
    return std::numeric_limits<float>::quiet_NaN();
  const auto low = [](double at, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(std::floor(at), 0.0, static_cast<double>(count - 1)));
  };
  const std::size_t c0 = low(x, g.columns), r0 = low(y, g.rows);
  const std::size_t c1 = std::min(c0 + 1, g.columns - 1), r1 = std::min(r0 + 1, g.rows - 1);
  const double u = std::clamp(x - static_cast<double>(c0), 0.0, 1.0),
               v = std::clamp(y - static_cast<double>(r0), 0.0, 1.0);
  const double value =
      (1.0 - v) * ((1.0 - u) * static_cast<double>(grid.at(r0, c0)) + u * static_cast<double>(grid.at(r0, c1))) +
      v * ((1.0 - u) * static_cast<double>(grid.at(r1, c0)) + u * static_cast<double>(grid.at(r1, c1)));
  if (std::isfinite(value)) return static_cast<float>(value);
  return grid.at(v < 0.5 ? r0 : r1, u < 0.5 ? c0 : c1);
}

// A raster of any other CRS: ups at its own cells, then resampled into cells of about the same size.
Grid<float> from_crs(Grid<float> heights, const std::string& crs, const geodesy::CrsConverter& converter) {
  const geometry::GridGeometry g = heights.geometry;
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity()), high = -low;
  std::vector<Vec3> row(g.columns);
  for (std::size_t r = 0; r < g.rows; ++r) {
    for (std::size_t c = 0; c < g.columns; ++c) {
      const Vec2 at = g.centre(r, c);
      const float value = heights.at(r, c);
      row[c] = Vec3(at.x(), at.y(), std::isfinite(value) ? static_cast<double>(value) : 0.0);
    }
    converter.to_local(row);
    for (std::size_t c = 0; c < g.columns; ++c) {
      low = low.cwiseMin(row[c].head<2>()), high = high.cwiseMax(row[c].head<2>());
      if (std::isfinite(heights.at(r, c))) heights.at(r, c) = static_cast<float>(row[c].z());
    }
  }
  const Vec2 middle = g.centre(g.rows / 2, g.columns / 2);
  const double cell = 0.5 * ((converter.to_local(Vec3(middle.x() + g.cell, middle.y(), 0.0)) -
                              converter.to_local(Vec3(middle.x(), middle.y(), 0.0)))
                                 .head<2>()
                                 .norm() +
                             (converter.to_local(Vec3(middle.x(), middle.y() + g.cell, 0.0)) -
                              converter.to_local(Vec3(middle.x(), middle.y(), 0.0)))
                                 .head<2>()
                                 .norm());
  const geometry::GridGeometry made = geometry::covering_grid(low, high, cell);
  if (!(static_cast<double>(made.cells()) <= kMostGrowth * static_cast<double>(g.cells()) + 1e4))
    throw base::Error(base::ErrorCode::crs_mismatch, "the terrain's cells are far from square on the ground")
        .found(crs)
        .hint("Warp the raster to a projected CRS, such as the UTM zone of the place");
  Grid<float> up(made, std::numeric_limits<float>::quiet_NaN());
  std::vector<Vec3> line(made.columns);
  for (std::size_t r = 0; r < made.rows; ++r) {
    for (std::size_t c = 0; c < made.columns; ++c) {
      const Vec2 at = made.centre(r, c);
      line[c] = Vec3(at.x(), at.y(), 0.0);
    }
    converter.from_local(line);
    for (std::size_t c = 0; c < made.columns; ++c) up.at(r, c) = sample(heights, line[c].head<2>());
  }
  return up;
}

}  // namespace

TerrainHeight::TerrainHeight(const std::filesystem::path& path, const geodesy::LocalFrame& frame) {
  const io::Raster raster = io::read_raster(path);
  if (raster.crs.empty())
    throw base::Error(base::ErrorCode::crs_mismatch, "the terrain declares no coordinate reference system")
        .file(path.string())
        .hint("Write it into the file, for example with gdal_edit.py -a_srs");
  try {
    const geodesy::CrsConverter converter(raster.crs, frame);
    up_ = is_local(converter) ? to_up(ground_band(raster, path), frame)
                              : from_crs(ground_band(raster, path), raster.crs, converter);
  } catch (base::Error& error) {
    error.default_file(path.string());
    throw;
  }
  lowest_ = std::numeric_limits<double>::infinity();
  highest_ = -lowest_;
  for (const float value : up_.values) {
    if (!std::isfinite(value)) continue;
    lowest_ = std::min(lowest_, static_cast<double>(value));
    highest_ = std::max(highest_, static_cast<double>(value));
  }
}

std::optional<double> TerrainHeight::up(double east, double north) const {
  const auto& g = up_.geometry;
  if (const auto cell = g.cell_at({east, north})) {
    const float value = up_.at(cell->first, cell->second);
    if (std::isfinite(value)) return static_cast<double>(value);
  }
  const auto index = [](double offset, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(offset, 0.0, static_cast<double>(count)));
  };
  const std::size_t c0 = index((east - kReach - g.west) / g.cell, g.columns),
                    c1 = index((east + kReach - g.west) / g.cell + 1.0, g.columns),
                    r0 = index((g.north - north - kReach) / g.cell, g.rows),
                    r1 = index((g.north - north + kReach) / g.cell + 1.0, g.rows);
  std::optional<double> best;
  double nearest = kReach * kReach;
  for (std::size_t r = r0; r < r1; ++r)
    for (std::size_t c = c0; c < c1; ++c) {
      const double distance = (g.centre(r, c) - Vec2(east, north)).squaredNorm();
      if (!std::isfinite(up_.at(r, c)) || distance >= nearest) continue;
      nearest = distance;
      best = static_cast<double>(up_.at(r, c));
    }
  return best;
}

std::optional<double> TerrainHeight::depth(const Vec3& origin, const Vec3& direction) const {
  const double sink = -direction.z();
  if (!(sink > 0.0) || !(highest_ >= lowest_)) return std::nullopt;
  const double first = std::max(0.0, (origin.z() - highest_) / sink), last = (origin.z() - lowest_) / sink;
  const double step = 0.5 * up_.geometry.cell / std::max(direction.head<2>().norm(), sink);
  constexpr double kMostSteps = 1e6;  // a level ray over a huge raster says nothing useful about depth
  if (!((last - first) / step < kMostSteps)) return std::nullopt;
  double above = std::numeric_limits<double>::quiet_NaN();  // height above ground at the step before; NaN = unknown
  for (double d = first; d <= last + step; d += step) {
    const Vec3 p = origin + d * direction;
    const auto cell = up_.geometry.cell_at(p.head<2>());
    if (!cell || !std::isfinite(up_.at(cell->first, cell->second))) {
      above = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    const double height = p.z() - static_cast<double>(up_.at(cell->first, cell->second));
    if (height <= 0.0) return std::isfinite(above) ? d - step * (-height) / (above - height) : d;
    above = height;
  }
  return std::nullopt;
}

}  // namespace cairn::pipeline
