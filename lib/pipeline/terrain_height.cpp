#include "pipeline/terrain_height.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "io/raster.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Grid;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kReach = 2.0;  // m; how far an empty cell may borrow a height

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

}  // namespace

TerrainHeight::TerrainHeight(const std::filesystem::path& path, const geodesy::LocalFrame& frame) {
  const io::Raster raster = io::read_raster(path);
  // A transverse Mercator about the survey's origin: anything else is another place or another unit.
  if (raster.crs.find("Transverse Mercator") == std::string::npos || raster.crs.find("UTM") != std::string::npos)
    throw base::Error(base::ErrorCode::crs_mismatch, "the terrain is not in the survey's local frame")
        .file(path.string())
        .hint("Use the surface.tif that 'cairn run' wrote for this survey");
  up_ = ground_band(raster, path);
  lowest_ = std::numeric_limits<double>::infinity();
  highest_ = -lowest_;
  for (std::size_t r = 0; r < up_.geometry.rows; ++r)
    for (std::size_t c = 0; c < up_.geometry.columns; ++c) {
      float& value = up_.at(r, c);
      if (!std::isfinite(value)) continue;
      const Vec2 at = up_.geometry.centre(r, c);
      const double level = frame.to_geodetic(Vec3(at.x(), at.y(), 0.0)).height_m;
      value = static_cast<float>(static_cast<double>(value) - level);
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
