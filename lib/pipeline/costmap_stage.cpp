#include "pipeline/costmap_stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "ground/inflation.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/costmap_products.hpp"
#include "pipeline/costmap_scans.hpp"
#include "pipeline/costmap_sources.hpp"
#include "pipeline/map_plane.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::ErrorCode;
using geometry::Grid;
using geometry::GridGeometry;
using ground::CellRegion;
using ground::Occupancy;
using ground::OccupancyGrid;

// Heights to drive on: the bare ground where the raster has it (trees are no obstacles), else its first band of
// heights.
const Grid<float>& height_band(const io::Raster& raster, const fs::path& path, bool bare) {
  const Grid<float>* first = nullptr;
  for (const auto& band : raster.bands) {
    const auto* values = std::get_if<Grid<float>>(&band.values);
    if (values == nullptr) continue;
    if (bare && band.name == "ground") return *values;
    if (first == nullptr) first = values;
  }
  if (first == nullptr) throw Error(ErrorCode::invalid_input, "the raster has no band of heights").file(path.string());
  return *first;
}

// Free where a height is known, unknown elsewhere.
OccupancyGrid known_ground(const Grid<float>& heights) {
  OccupancyGrid grid(heights.geometry, Occupancy::unknown);
  for (std::size_t i = 0; i < grid.values.size(); ++i)
    if (std::isfinite(heights.values[i])) grid.values[i] = Occupancy::free;
  return grid;
}

// Ground that may be driven on, and terrain.tif.
OccupancyGrid judged_ground(const Grid<float>& heights, const std::string& crs, const fs::path& out,
                            const ground::TerrainLayerOptions& options) {
  ground::TerrainLayers layers = ground::terrain_layers(heights, options);
  OccupancyGrid grid = ground::drivable(layers);
  io::write_cog(
      out / "terrain.tif",
      {{"slope_deg", "deg", "slope of the least-squares plane about the cell", std::move(layers.slope_deg), {}},
       {"roughness_m", "m", "root mean square of the heights about that plane", std::move(layers.roughness_m), {}},
       {"step_m", "m", "largest difference of heights to a neighbour", std::move(layers.step_m), {}},
       {"traversability", "", "1 level and smooth .. 0 cannot be driven", std::move(layers.traversability), {}}},
      crs);
  return grid;
}

GridGeometry covering(double west, double south, double east, double north, double cell) {
  const auto cells = [cell](double extent) {
    return static_cast<std::size_t>(std::max(1.0, std::ceil(extent / cell - 1e-6)));
  };
  return {west, north, cell, cells(east - west), cells(north - south)};
}

GridGeometry extent_of(const std::string& text, double cell) {
  std::array<double, 4> e{};
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= text.size() && count <= 4; ++count) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto value = base::parse_real(std::string_view(text).substr(begin, end - begin));
    if (!value || !std::isfinite(*value) || count == 4) {
      count = 9;
      break;
    }
    e[count] = *value;
    begin = end + 1;
  }
  if (count != 4 || !(e[0] < e[2] && e[1] < e[3]))
    throw Error(ErrorCode::invalid_argument, "--extent is not an extent")
        .found("'" + text + "'")
        .allowed("WEST,SOUTH,EAST,NORTH in local metres, west < east, south < north");
  return covering(e[0], e[1], e[2], e[3], cell);
}

std::uint8_t as_100(Occupancy o) {
  const std::uint8_t known = o == Occupancy::occupied ? 100 : 0;
  return o == Occupancy::unknown ? io::kOccupancyUnknown : known;
}

// Occupied and unknown cells of one row of the band `occupancy`.
std::pair<std::uint64_t, std::uint64_t> count_row(std::span<const std::uint8_t> row) {
  std::uint32_t occupied = 0, unknown = 0;
  for (const std::uint8_t value : row) {
    occupied += value == 100 ? 1U : 0U;
    unknown += value == io::kOccupancyUnknown ? 1U : 0U;
  }
  return {occupied, unknown};
}

struct Sources {
  std::unique_ptr<OccupancySource> prior, surface;
  std::optional<ObstacleLayer> obstacles;
  std::optional<ScanLayer> scans;
};

// Rows of the map with every source, and what becomes of them.
class Composition {
 public:
  Composition(const GridGeometry& map, Sources& sources, const CostmapStageOptions& options)
      : map_(map), sources_(sources), options_(options), inflation_(options.cost) {
    if (options.keepout_inflate_m > 0.0) {
      ground::CostmapOptions grown = options.cost;
      grown.radius_m = options.keepout_inflate_m;
      grown.alpha = 100.0;  // as little beyond the radius as there may be
      keepout_.emplace(grown);
    }
    margin_ = static_cast<std::size_t>(std::max(inflation_.reach(), keepout_ ? keepout_->reach() : 0));
  }

  [[nodiscard]] std::size_t margin() const { return margin_; }
  [[nodiscard]] std::vector<CostmapBand> bands() const {
    std::vector<CostmapBand> bands{
        {"cost", "cost of driving, paper B equation (9): 254 obstacle, 253 contact, 252 exp(-alpha (D - R))"},
        {"occupancy", "all sources combined: 0 free, 100 occupied"}};
    if (sources_.prior) bands.push_back({"prior", "prior map: 0 free, 100 occupied"});
    if (sources_.surface)
      bands.push_back({options_.terrain_layers ? "terrain" : "surface",
                       options_.terrain_layers ? "0 ground that can be driven, 100 that cannot" : "0 ground is known"});
    if (sources_.obstacles) bands.push_back({"obstacles", "100 obstacles as seen from the air"});
    if (sources_.scans) bands.push_back({"scans", "scans of the vehicle: 0 free, 100 occupied"});
    return bands;
  }

  // Bands and keep-out mask of the rows [first, first + rows).
  void rows(std::size_t first, std::size_t rows, std::vector<std::vector<std::uint8_t>>& bands,
            std::vector<std::uint8_t>& keepout) {
    const CellRegion seen = ground::widened({first, 0, rows, map_.columns}, margin_, map_);
    const GridGeometry shape{map_.west, map_.north - static_cast<double>(seen.row) * map_.cell, map_.cell, map_.columns,
                             seen.rows};
    const CellRegion inner{first - seen.row, 0, rows, map_.columns};
    OccupancyGrid combined(shape, Occupancy::unknown), layer(shape, Occupancy::unknown);
    std::size_t band = 2;
    const auto keep = [&](const OccupancyGrid& grid) {
      auto& out = bands[band++];
      const auto* begin = &grid.values[inner.row * map_.columns];
      std::transform(begin, begin + rows * map_.columns, out.begin(), as_100);
    };
    if (!sources_.prior && !sources_.surface) std::fill(combined.values.begin(), combined.values.end(), outside());
    // The prior map and the known ground: what either blocks is blocked, what either knows is known.
    if (sources_.prior) {
      sources_.prior->rows(map_, seen.row, combined);
      keep(combined);
    }
    if (sources_.surface) {
      sources_.surface->rows(map_, seen.row, layer);
      keep(layer);
      for (std::size_t i = 0; i < layer.values.size(); ++i)
        if (layer.values[i] == Occupancy::occupied || combined.values[i] == Occupancy::unknown)
          combined.values[i] = layer.values[i];
    }
    OccupancyGrid obstacles, scans;
    if (sources_.obstacles) {
      obstacles = OccupancyGrid(shape, Occupancy::unknown);
      ground::mark_obstacles(sources_.obstacles->obstacles, map_, seen.row, obstacles);
      for (const auto& outline : sources_.obstacles->outlines)
        ground::mark_polygon(outline, Occupancy::occupied, map_, seen.row, obstacles);
      keep(obstacles);
    }
    if (sources_.scans) {
      scans = OccupancyGrid(shape, Occupancy::unknown);
      sources_.scans->rows(seen.row, scans);
      keep(scans);
    }
    ground::combine(combined, sources_.obstacles ? &obstacles : nullptr, sources_.scans ? &scans : nullptr,
                    options_.combine, ground::whole(shape), combined);
    inflation_.run(combined, inner, bands[0].data(), map_.columns);
    const auto* middle = &combined.values[inner.row * map_.columns];
    std::transform(middle, middle + rows * map_.columns, bands[1].begin(), as_100);
    std::copy_n(bands[1].begin(), rows * map_.columns, keepout.begin());
    if (keepout_) {
      std::vector<std::uint8_t> grown(rows * map_.columns);
      keepout_->run(combined, inner, grown.data(), map_.columns);
      for (std::size_t i = 0; i < grown.size(); ++i)
        if (grown[i] == ground::kInscribed) keepout[i] = 100;
    }
  }

 private:
  // Ground that no source says anything about.
  [[nodiscard]] Occupancy outside() const {
    if (options_.outside == "free") return Occupancy::free;
    return options_.outside == "occupied" ? Occupancy::occupied : Occupancy::unknown;
  }

  const GridGeometry& map_;
  Sources& sources_;
  const CostmapStageOptions& options_;
  ground::Inflation inflation_;
  std::optional<ground::Inflation> keepout_;
  std::size_t margin_ = 1;
};

// Rows at once: layers of about 32 million cells, and whole blocks of the raster.
std::size_t strip_rows(const GridGeometry& map, const CostmapStageOptions& options) {
  if (options.strip_rows > 0) return std::min(static_cast<std::size_t>(options.strip_rows), map.rows);
  constexpr std::size_t kCells = std::size_t{1} << 25U, kBlock = 512;
  return std::min(map.rows, std::max(kBlock, kCells / map.columns / kBlock * kBlock));
}

// Reads every source that is there; the plane they share is fixed on the way.
Sources open_sources(const CostmapInputs& in, const fs::path& out, const CostmapStageOptions& options, MapPlane& plane,
                     base::RunContext& ctx) {
  Sources sources;
  if (!in.survey.empty()) plane.join_frame(io::read_survey(in.survey).manifest.origin, in.survey);
  const bool records = !in.obstacles.empty() && in.obstacles.extension() == ".json";
  if (records) sources.obstacles = read_obstacle_records(in.obstacles, plane);
  if (!in.prior.empty() && !is_polygon_file(in.prior)) sources.prior = open_prior(in.prior, options, plane, ctx);
  if (!in.surface.empty()) {
    const io::Raster raster = io::read_raster(in.surface);
    plane.join_crs(raster.crs, in.surface);
    const Grid<float>& heights = height_band(raster, in.surface, options.terrain_layers);
    sources.surface =
        make_grid_source(options.terrain_layers ? judged_ground(heights, plane.raster_crs(), out, options.terrain)
                                                : known_ground(heights));
  }
  if (!in.prior.empty() && is_polygon_file(in.prior))
    sources.prior = open_prior_polygons(in.prior, options, plane, ctx);
  if (!in.obstacles.empty() && !records) sources.obstacles = read_obstacle_layer(in.obstacles, plane);
  return sources;
}

GridGeometry map_geometry(const Sources& sources, const CostmapStageOptions& options) {
  const double cell = options.cost.resolution_m;
  if (!options.extent.empty()) return extent_of(options.extent, cell);
  for (const auto* source : {&sources.prior, &sources.surface})
    if (*source != nullptr)
      if (const auto g = (*source)->geometry()) return covering(g->west, g->south(), g->east(), g->north, cell);
  throw Error(ErrorCode::invalid_argument, "nothing says how far the map reaches")
      .hint("Give --prior, --surface or --extent WEST,SOUTH,EAST,NORTH");
}

void warn_of_resampling(const Sources& sources, const GridGeometry& map, base::RunContext& ctx) {
  if (!sources.prior) return;
  const auto g = sources.prior->geometry();
  if (!g || std::abs(g->cell - map.cell) < 1e-9) return;
  ctx.warn("costmap: the prior map of " + base::to_text(g->cell) + " m cells is resampled to " +
           base::to_text(map.cell) + " m; a cell is occupied where any cell under it is");
}

std::optional<io::MapGeoreference> georeference_of(const MapPlane& plane) {
  const auto place = plane.place_of_zero();
  if (!place) return std::nullopt;
  return io::MapGeoreference{place->position, place->height_type, place->geoid, plane.raster_crs()};
}

io::MapMode mode_of(const std::string& name) {
  for (const auto mode : {io::MapMode::scale, io::MapMode::raw})
    if (name == io::name_of(mode)) return mode;
  return io::MapMode::trinary;
}

}  // namespace

std::vector<fs::path> costmap_files(const CostmapInputs& in) {
  std::vector<fs::path> files;
  for (const auto* file : {&in.prior, &in.surface, &in.obstacles, &in.scans, &in.vehicle})
    if (!file->empty()) files.push_back(*file);
  if (in.prior.extension() != ".yaml" && in.prior.extension() != ".yml") return files;
  files.push_back(io::ros_map_image(in.prior));
  fs::path sidecar = in.prior;
  sidecar.replace_extension(".georeference.json");
  if (fs::exists(sidecar)) files.push_back(sidecar);
  return files;
}

Outcome costmap_stage(const CostmapInputs& in, const fs::path& out, const CostmapStageOptions& given,
                      base::RunContext& ctx) {
  CostmapStageOptions options = given;
  base::validate(base::bind_options(options), "costmap");
  if (in.scans.empty() != in.vehicle.empty())
    throw Error(ErrorCode::invalid_argument, "--scans and --vehicle need one another");
  if (options.terrain_layers && in.surface.empty())
    throw Error(ErrorCode::invalid_argument, "--terrain-layers needs --surface");
  MapPlane plane;
  Sources sources = open_sources(in, out, options, plane, ctx);
  const GridGeometry map = map_geometry(sources, options);
  warn_of_resampling(sources, map, ctx);
  if (!in.scans.empty()) sources.scans = gather_scans(in.scans, in.vehicle, map, options, ctx);

  Composition composition(map, sources, options);
  CostmapProducts products(out, map, composition.bands(), plane.raster_crs(), mode_of(options.map_mode),
                           georeference_of(plane));
  const std::size_t height = strip_rows(map, options);
  const std::size_t bands = composition.bands().size();
  ctx.check_memory(products.kept_bytes() + (height + 2 * composition.margin()) * map.columns * (bands + 4),
                   "the costmap");
  std::vector<std::vector<std::uint8_t>> values(bands, std::vector<std::uint8_t>(height * map.columns));
  std::vector<std::uint8_t> keepout(height * map.columns);
  std::uint64_t occupied = 0, unknown = 0;
  for (std::size_t first = 0; first < map.rows; first += height) {
    ctx.check_stop();
    ctx.progress("rows", first, map.rows);
    const std::size_t rows = std::min(height, map.rows - first);
    composition.rows(first, rows, values, keepout);
    for (std::size_t r = 0; r < rows; ++r) {
      const auto [row_occupied, row_unknown] = count_row(std::span(values[1]).subspan(r * map.columns, map.columns));
      occupied += row_occupied;
      unknown += row_unknown;
    }
    products.rows(rows, values, keepout);
  }
  products.finish();
  if (!products.has_maps())
    ctx.warn("costmap: no ROS map, because ROS cannot load more than 2^31 cells; cut windows with --extent");

  Outcome outcome;
  const double area = map.cell * map.cell;
  outcome.summary = io::Json::object({{"columns", map.columns},
                                      {"rows", map.rows},
                                      {"resolution_m", map.cell},
                                      {"radius_m", options.cost.radius_m},
                                      {"free_m2", static_cast<double>(map.cells() - occupied - unknown) * area},
                                      {"occupied_m2", static_cast<double>(occupied) * area},
                                      {"unknown_m2", static_cast<double>(unknown) * area},
                                      {"raster", products.streams() ? "tiled" : "cog"},
                                      {"ros_map", products.has_maps()},
                                      {"georeferenced", plane.known()}});
  if (sources.obstacles) {
    OccupancyGrid none({map.west, map.north, map.cell, map.columns, 0}, Occupancy::unknown);
    const auto marked = ground::mark_obstacles(sources.obstacles->obstacles, map, 0, none);
    outcome.rejects = sources.obstacles->rejects;
    for (const std::size_t i : marked.outside)
      outcome.rejects.push_back({"obstacle " + std::to_string(sources.obstacles->obstacles[i].target.value),
                                 "outside_map", "the obstacle does not touch the mapped area"});
    for (const std::size_t i : marked.not_finite)
      outcome.rejects.push_back({"obstacle " + std::to_string(sources.obstacles->obstacles[i].target.value),
                                 "not_finite", "the obstacle's place or width is no finite number"});
    outcome.summary.set("obstacles", sources.obstacles->read);
    outcome.summary.set("obstacles_outside", marked.outside.size());
  }
  if (sources.scans) {
    outcome.summary.set("scans", sources.scans->summary);
    outcome.rejects.insert(outcome.rejects.end(), sources.scans->rejects.begin(), sources.scans->rejects.end());
  }
  outcome.summary.set("rejects_by_reason", count_by_reason(outcome.rejects));
  return outcome;
}

}  // namespace cairn::pipeline
