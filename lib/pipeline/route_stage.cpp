#include "pipeline/route_stage.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"
#include "geodesy/local_frame.hpp"
#include "ground/costmap.hpp"
#include "ground/distance.hpp"
#include "io/geojson.hpp"
#include "io/raster.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Grid;
using geometry::Vec2;
using ground::Cell;

Vec2 parse_pair(const std::string& text, const std::string& name, const std::string& form) {
  const auto comma = text.find(',');
  if (comma != std::string::npos) {
    const auto first = base::parse_real(std::string_view(text).substr(0, comma));
    const auto second = base::parse_real(std::string_view(text).substr(comma + 1));
    if (first && second && std::isfinite(*first) && std::isfinite(*second)) return {*first, *second};
  }
  throw Error(ErrorCode::invalid_argument, "--" + name + " is not a position").found("'" + text + "'").allowed(form);
}

// A geographic position in the raster's coordinates: the local frame about it has its zero there.
Vec2 from_geographic(const Vec2& latitude_longitude, const std::string& crs) {
  const geodesy::LocalFrame frame({latitude_longitude.x(), latitude_longitude.y(), 0.0});
  const geometry::Vec3 p = geodesy::CrsConverter(crs, frame).from_local(geometry::Vec3::Zero());
  return {p.x(), p.y()};
}

std::optional<Vec2> end_of(const std::string& name, const std::string& geographic, const std::string& local,
                           const std::string& crs) {
  if (!geographic.empty() && !local.empty())
    throw Error(ErrorCode::invalid_argument, "--" + name + " and --" + name + "-local exclude one another");
  if (!local.empty()) return parse_pair(local, name + "-local", "EAST,NORTH in metres");
  if (!geographic.empty()) return from_geographic(parse_pair(geographic, name, "LAT,LON in degrees"), crs);
  return std::nullopt;
}

Cell cell_of(const Grid<std::uint8_t>& cost, const Vec2& p, const std::string& name) {
  if (const auto cell = cost.geometry.cell_at(p)) return *cell;
  const auto& g = cost.geometry;
  throw Error(ErrorCode::failed_precondition, "the " + name + " lies outside the costmap")
      .found(base::to_fixed(p.x(), 2) + "," + base::to_fixed(p.y(), 2))
      .allowed("east " + base::to_fixed(g.west, 2) + " to " + base::to_fixed(g.east(), 2) + ", north " +
               base::to_fixed(g.south(), 2) + " to " + base::to_fixed(g.north, 2));
}

// Least distance from a cell of the path to an obstacle cell [m]; capped where nothing is near.
double clearance(const Grid<std::uint8_t>& cost, const std::vector<Vec2>& path) {
  constexpr double kFarthest_m = 25.0;
  Grid<std::uint8_t> lethal(cost.geometry, 0);
  for (std::size_t i = 0; i < cost.values.size(); ++i) lethal.values[i] = cost.values[i] == ground::kLethal ? 1 : 0;
  const int reach = std::clamp(static_cast<int>(kFarthest_m / cost.geometry.cell), 1, 32000);
  const auto squared = ground::squared_distance(lethal, reach);
  std::int32_t least = reach * reach;
  for (const auto& p : path)
    if (const auto cell = cost.geometry.cell_at(p)) least = std::min(least, squared.at(cell->first, cell->second));
  return std::sqrt(static_cast<double>(least)) * cost.geometry.cell;
}

io::Json pair_json(const Vec2& p) {
  return io::Json(std::vector<double>{p.x(), p.y()});
}

io::Layer route_layer(const std::vector<Vec2>& path, const std::string& crs, double length) {
  // Any frame serves to come from the raster's CRS to latitude and longitude.
  const geodesy::LocalFrame zero({0.0, 0.0, 0.0});
  const geodesy::CrsConverter converter(crs, zero);
  io::Feature feature;
  auto& line = feature.parts.emplace_back().emplace_back();
  for (const auto& p : path) line.push_back(zero.to_geodetic(converter.to_local(geometry::Vec3(p.x(), p.y(), 0.0))));
  feature.values = {length};
  io::Layer layer;
  layer.name = "route";
  layer.title = "Route over the costmap";
  layer.kind = io::GeometryKind::line;
  layer.with_heights = false;
  layer.columns = {{"length_m", io::ColumnType::real, "m", "Length of the path"}};
  layer.features = {feature};
  return layer;
}

}  // namespace

Outcome route_stage(const std::filesystem::path& costmap, const std::filesystem::path& out,
                    const RouteStageOptions& options, base::RunContext& ctx) {
  const io::Raster raster = io::read_raster(costmap);
  const auto* cost = raster.bands.empty() ? nullptr : std::get_if<Grid<std::uint8_t>>(&raster.bands[0].values);
  if (cost == nullptr)
    throw Error(ErrorCode::invalid_input, "not a costmap: the first band is not of bytes")
        .file(costmap.string())
        .hint("Give the costmap.tif that 'cairn costmap' writes");
  const auto from = end_of("from", options.from, options.from_local, raster.crs);
  const auto to = end_of("to", options.to, options.to_local, raster.crs);
  if (from.has_value() != to.has_value())
    throw Error(ErrorCode::invalid_argument, "a route needs both ends, or none").hint("Give --from and --to");

  Cell start, goal;
  if (from) {
    start = cell_of(*cost, *from, "start");
    goal = cell_of(*cost, *to, "goal");
  } else {
    const auto ends = ground::far_apart(*cost, options.route);
    if (!ends) throw Error(ErrorCode::failed_precondition, "the costmap has no drivable cell").file(costmap.string());
    start = ends->first;
    goal = ends->second;
  }
  const ground::Route route = ground::find_route(*cost, start, goal, options.route, ctx);
  if (!route.found)
    throw Error(ErrorCode::failed_precondition, "there is no route")
        .file(costmap.string())
        .found(route.reason)
        .hint(route.reason == "no_path" ? "Obstacles or unknown ground lie between the ends; try --allow-unknown"
                                        : "Move the end to drivable ground; cells of cost 253 and more are blocked");

  const auto corners = ground::without_collinear(route.path);
  io::Json path = io::Json::array();
  for (const auto& p : corners) path.push(pair_json(p));
  Outcome outcome;
  outcome.summary = io::Json::object({{"from_m", pair_json(route.path.front())},
                                      {"to_m", pair_json(route.path.back())},
                                      {"ends", from ? "given" : "chosen: far apart in the largest drivable region"},
                                      {"length_m", route.length_m},
                                      {"weighted_length_m", route.weighted_length_m},
                                      {"clearance_m", clearance(*cost, route.path)},
                                      {"expansions", static_cast<std::int64_t>(route.expansions)}});
  io::Json file = outcome.summary;
  file.set("path_m", path);
  base::write_file(out / "route.json", file.dump() + "\n");
  io::write_geojson(out / "route.geojson", route_layer(corners, raster.crs, route.length_m));
  return outcome;
}

}  // namespace cairn::pipeline
