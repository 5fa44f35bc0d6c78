#include "pipeline/costmap_sources.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "ground/class_table.hpp"
#include "ground/resampling.hpp"
#include "io/obstacles_json.hpp"
#include "io/raster_rows.hpp"
#include "io/ros_map.hpp"
#include "io/vector.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::ErrorCode;
using geometry::GridGeometry;
using geometry::Ring;
using geometry::Vec2;
using ground::Occupancy;
using ground::OccupancyGrid;

class GridSource final : public OccupancySource {
 public:
  explicit GridSource(OccupancyGrid grid) : grid_(std::move(grid)) {}
  [[nodiscard]] std::optional<GridGeometry> geometry() const override { return grid_.geometry; }
  void rows(const GridGeometry& full, std::size_t first, OccupancyGrid& strip) override {
    if (!resampling_) resampling_.emplace(grid_.geometry, full);
    resampling_->rows(grid_, 0, first, strip);
  }

 private:
  OccupancyGrid grid_;
  std::optional<ground::Resampling> resampling_;
};

class TurnedSource final : public OccupancySource {
 public:
  TurnedSource(OccupancyGrid grid, double yaw) : grid_(std::move(grid)), yaw_(yaw) {}
  [[nodiscard]] std::optional<GridGeometry> geometry() const override {
    return ground::grid_around_turned(grid_.geometry, yaw_, grid_.geometry.cell);
  }
  void rows(const GridGeometry& full, std::size_t first, OccupancyGrid& strip) override {
    if (turned_.values.empty()) turned_ = ground::resampled_turned(grid_, yaw_, full);
    const auto* begin = &turned_.values[first * full.columns];
    std::copy(begin, begin + strip.values.size(), strip.values.begin());
  }

 private:
  OccupancyGrid grid_, turned_;
  double yaw_;
};

// A GeoTIFF of occupancy or cost, read as far as it is needed.
class RasterSource final : public OccupancySource {
 public:
  RasterSource(const fs::path& path, double occupied_from) : raster_(path) {
    const auto& bands = raster_.info().bands;
    if (bands.empty()) throw Error(ErrorCode::invalid_input, "a raster without bands").file(path.string());
    const auto named = [&](const char* name) {
      return static_cast<std::size_t>(
          std::find_if(bands.begin(), bands.end(), [&](const auto& b) { return b.name == name; }) - bands.begin());
    };
    threshold_ = occupied_from;
    if (named("occupancy") < bands.size()) {
      band_ = named("occupancy");
    } else if (named("cost") < bands.size()) {
      band_ = named("cost");
      threshold_ = ground::kInscribed;
    }
    const auto nodata = raster_.nodata(band_);
    for (std::size_t value = 0; value < 256; ++value) {
      const bool unknown = nodata ? static_cast<double>(value) == *nodata : value == ground::kUnknown;
      table_[value] = unknown ? Occupancy::unknown
                              : (static_cast<double>(value) >= threshold_ ? Occupancy::occupied : Occupancy::free);
    }
  }
  [[nodiscard]] const std::string& crs() const { return raster_.info().crs; }
  [[nodiscard]] std::optional<GridGeometry> geometry() const override { return raster_.info().geometry; }

  void rows(const GridGeometry& full, std::size_t first, OccupancyGrid& strip) override {
    const GridGeometry& g = raster_.info().geometry;
    if (!resampling_) resampling_.emplace(g, full);
    const auto [begin, end] = resampling_->rows_needed(first, strip.geometry.rows);
    if (!(full == g)) {
      OccupancyGrid window({g.west, g.north, g.cell, g.columns, end - begin}, Occupancy::unknown);
      read(begin, end - begin, window.values);
      resampling_->rows(window, begin, first, strip);
      return;
    }
    read(first, strip.geometry.rows, strip.values);
  }

 private:
  void read(std::size_t first, std::size_t rows, std::vector<Occupancy>& out) {
    if (rows == 0) return;
    const std::size_t cells = rows * raster_.info().geometry.columns;
    if (raster_.is_byte(band_)) {
      bytes_.resize(cells);
      raster_.read(band_, first, rows, std::span(bytes_));
      std::transform(bytes_.begin(), bytes_.end(), out.begin(), [&](std::uint8_t v) { return table_[v]; });
      return;
    }
    std::vector<double> row(raster_.info().geometry.columns);
    for (std::size_t r = 0; r < rows; ++r) {
      raster_.read(band_, first + r, 1, std::span(row));
      std::transform(row.begin(), row.end(), out.begin() + static_cast<std::ptrdiff_t>(r * row.size()), [&](double v) {
        if (!std::isfinite(v) || v < 0.0) return Occupancy::unknown;
        return v >= threshold_ ? Occupancy::occupied : Occupancy::free;
      });
    }
  }

  io::RasterRows raster_;
  std::size_t band_ = 0;
  double threshold_ = 50.0;
  std::array<Occupancy, 256> table_{};
  std::vector<std::uint8_t> bytes_;
  std::optional<ground::Resampling> resampling_;
};

// Free ground, then unknown, then blocked: what blocks wins.
class PolygonSource final : public OccupancySource {
 public:
  struct Polygon {
    std::vector<Ring> rings;
    Occupancy value = Occupancy::occupied;
  };
  PolygonSource(std::vector<Polygon> polygons, Occupancy outside, double cell)
      : polygons_(std::move(polygons)), outside_(outside), cell_(cell) {
    const auto rank = [](const Polygon& p) {
      return p.value == Occupancy::occupied ? 2 : p.value == Occupancy::unknown;
    };
    std::stable_sort(polygons_.begin(), polygons_.end(),
                     [&](const Polygon& a, const Polygon& b) { return rank(a) < rank(b); });
  }
  [[nodiscard]] std::optional<GridGeometry> geometry() const override {
    Vec2 lo = Vec2::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
    for (const auto& polygon : polygons_)
      for (const auto& ring : polygon.rings)
        for (const Vec2& p : ring) {
          lo = lo.cwiseMin(p);
          hi = hi.cwiseMax(p);
        }
    if (!(lo.x() <= hi.x())) return std::nullopt;
    return geometry::covering_grid(lo, hi, cell_);
  }
  void rows(const GridGeometry& full, std::size_t first, OccupancyGrid& strip) override {
    std::fill(strip.values.begin(), strip.values.end(), outside_);
    for (const auto& polygon : polygons_) ground::mark_polygon(polygon.rings, polygon.value, full, first, strip);
  }

 private:
  std::vector<Polygon> polygons_;
  Occupancy outside_;
  double cell_;
};

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

const io::Value* value_of(const io::ForeignLayer& layer, const io::BasicFeature<geometry::Vec3>& feature,
                          const char* column) {
  for (std::size_t i = 0; i < layer.columns.size() && i < feature.values.size(); ++i)
    if (layer.columns[i].name == column) return &feature.values[i];
  return nullptr;
}

std::optional<double> real_of(const io::Value* value) {
  if (value == nullptr) return std::nullopt;
  if (const auto* real = std::get_if<double>(value)) return *real;
  if (const auto* integer = std::get_if<std::int64_t>(value)) return static_cast<double>(*integer);
  return std::nullopt;
}

// Outer rings and holes of all parts of a polygon feature.
std::vector<Ring> rings_of(const io::BasicFeature<geometry::Vec3>& feature, const MapPlane::Projection& to_plane) {
  std::vector<Ring> rings;
  for (const auto& part : feature.parts)
    for (const auto& ring : part) rings.push_back(to_plane(ring));
  return rings;
}

// Free, unknown or occupied by the column `occupancy`: blocked, free, unknown, or 100, 0, -1.
Occupancy polygon_value(const io::ForeignLayer& layer, const io::BasicFeature<geometry::Vec3>& feature,
                        const fs::path& path, std::size_t index) {
  const io::Value* value = value_of(layer, feature, "occupancy");
  if (value == nullptr || std::holds_alternative<std::monostate>(*value)) return Occupancy::occupied;
  const std::string text = io::to_text(*value);
  if (text == "free" || text == "0") return Occupancy::free;
  if (text == "unknown" || text == "-1") return Occupancy::unknown;
  if (text == "blocked" || text == "occupied" || text == "100") return Occupancy::occupied;
  throw Error(ErrorCode::invalid_input, "an occupancy that is not known")
      .file(path.string())
      .record("layer '" + layer.name + "', feature " + std::to_string(index + 1))
      .found("'" + text + "'")
      .allowed("blocked, free, unknown, or 100, 0, -1");
}

}  // namespace

std::unique_ptr<OccupancySource> make_grid_source(OccupancyGrid grid) {
  return std::make_unique<GridSource>(std::move(grid));
}

bool is_polygon_file(const fs::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".gpkg" || extension == ".geojson" || extension == ".json" || extension == ".shp";
}

std::unique_ptr<OccupancySource> open_prior(const fs::path& path, const CostmapStageOptions& options, MapPlane& plane,
                                            base::RunContext& ctx) {
  const std::string extension = lower_extension(path);
  if (extension == ".tif" || extension == ".tiff") {
    auto source = std::make_unique<RasterSource>(path, options.prior_occupied_from);
    if (source->crs().empty())
      ctx.warn("costmap: the prior map declares no CRS; its coordinates are taken as those of the local frame");
    plane.join_crs(source->crs(), path);
    return source;
  }
  if (extension != ".yaml" && extension != ".yml")
    throw Error(ErrorCode::invalid_input, "a prior map of an unknown kind")
        .file(path.string())
        .found("'" + extension + "'")
        .allowed(".yaml (ROS map), .tif, .gpkg, .geojson, .shp");
  const io::RosMap map = io::read_ros_map(path, {options.accept_yaw});
  fs::path sidecar = path;
  sidecar.replace_extension(".georeference.json");
  if (fs::exists(sidecar)) {
    const io::MapGeoreference place = io::read_map_georeference(sidecar);
    plane.join_crs(place.crs_wkt, sidecar);
  } else {
    ctx.warn("costmap: no " + sidecar.filename().string() +
             " beside the prior map; its coordinates are taken as those of the local frame");
  }
  OccupancyGrid grid(map.occupancy.geometry, Occupancy::unknown);
  for (std::size_t i = 0; i < grid.values.size(); ++i) {
    const std::uint8_t value = map.occupancy.values[i];
    if (value == io::kOccupancyUnknown) continue;
    grid.values[i] = static_cast<double>(value) >= options.prior_occupied_from ? Occupancy::occupied : Occupancy::free;
  }
  if (map.yaw != 0.0) return std::make_unique<TurnedSource>(std::move(grid), map.yaw);
  return make_grid_source(std::move(grid));
}

std::unique_ptr<OccupancySource> open_prior_polygons(const fs::path& path, const CostmapStageOptions& options,
                                                     const MapPlane& plane, base::RunContext& ctx) {
  std::vector<PolygonSource::Polygon> polygons;
  bool some_free = false;
  std::size_t left_out = 0;
  for (const io::ForeignLayer& layer : io::read_vector(path)) {
    left_out += layer.rejects.size();
    if (layer.kind != io::GeometryKind::polygon) {
      left_out += layer.features.size();
      continue;
    }
    const auto to_plane = plane.projection(layer.crs, path);
    for (std::size_t i = 0; i < layer.features.size(); ++i) {
      PolygonSource::Polygon polygon{rings_of(layer.features[i], to_plane),
                                     polygon_value(layer, layer.features[i], path, i)};
      some_free = some_free || polygon.value == Occupancy::free;
      polygons.push_back(std::move(polygon));
    }
  }
  if (polygons.empty())
    throw Error(ErrorCode::invalid_input, "a prior map without polygons")
        .file(path.string())
        .hint("Draw what is blocked as polygons");
  if (left_out > 0)
    ctx.warn("costmap: " + std::to_string(left_out) + " features of the prior map are no polygons and are left out");
  Occupancy outside = some_free ? Occupancy::unknown : Occupancy::free;
  if (options.outside == "free") outside = Occupancy::free;
  if (options.outside == "unknown") outside = Occupancy::unknown;
  if (options.outside == "occupied") outside = Occupancy::occupied;
  return std::make_unique<PolygonSource>(std::move(polygons), outside, options.cost.resolution_m);
}

ObstacleLayer read_obstacle_records(const fs::path& path, MapPlane& plane) {
  io::ObstaclesFile file = io::read_obstacles(path);
  plane.join_frame(file.frame, path);
  ObstacleLayer result;
  result.obstacles = std::move(file.obstacles);
  result.read = result.obstacles.size();
  return result;
}

ObstacleLayer read_obstacle_layer(const fs::path& path, const MapPlane& plane) {
  const std::vector<io::ForeignLayer> layers = io::read_vector(path);
  const io::ForeignLayer* layer = nullptr;
  for (const auto& candidate : layers)
    if (candidate.name == "obstacles" || layers.size() == 1) layer = &candidate;
  if (layer == nullptr)
    throw Error(ErrorCode::invalid_input, "no layer of obstacles")
        .file(path.string())
        .found(std::to_string(layers.size()) + " layers")
        .allowed("a layer named 'obstacles', or one layer only");
  ObstacleLayer result;
  result.rejects = layer->rejects;
  result.read = layer->feature_count;
  const auto to_plane = plane.projection(layer->crs, path);
  for (std::size_t i = 0; i < layer->features.size(); ++i) {
    const auto& feature = layer->features[i];
    const std::string record = "obstacle " + std::to_string(i + 1);
    survey::Obstacle obstacle;
    obstacle.target = survey::TargetId(static_cast<decltype(obstacle.target.value)>(
        std::llround(real_of(value_of(*layer, feature, "id")).value_or(static_cast<double>(i + 1)))));
    if (const auto* kind = value_of(*layer, feature, "kind"); kind != nullptr) {
      const std::string text = io::to_text(*kind);
      for (const auto k : {survey::ObstacleKind::ignored, survey::ObstacleKind::vehicle})
        if (text == survey::name_of(k)) obstacle.kind = k;
    } else if (const auto* name = value_of(*layer, feature, "class"); name != nullptr) {
      obstacle.kind = ground::kind_of_class(io::to_text(*name), {}).value_or(survey::ObstacleKind::obstacle);
    }
    if (obstacle.kind != survey::ObstacleKind::obstacle) continue;
    obstacle.width_m = real_of(value_of(*layer, feature, "width_m")).value_or(0.0);
    if (feature.parts.empty() || layer->kind == io::GeometryKind::line) {
      result.rejects.push_back({record, "no_place", "an obstacle is a point or a polygon"});
    } else if (layer->kind == io::GeometryKind::polygon) {
      result.outlines.push_back(rings_of(feature, to_plane));
    } else {
      for (const auto& part : feature.parts)
        for (const Vec2& p : to_plane(part.at(0))) {
          obstacle.position = {p.x(), p.y(), 0.0};
          result.obstacles.push_back(obstacle);
        }
    }
  }
  return result;
}

}  // namespace cairn::pipeline
