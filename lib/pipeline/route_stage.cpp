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
#include "ground/path.hpp"
#include "io/geojson.hpp"
#include "io/obstacles_json.hpp"
#include "io/packets.hpp"
#include "io/raster.hpp"
#include "io/vehicle_csv.hpp"

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

constexpr double kFarthest_m = 25.0;  // clearances beyond are given as this

io::Json pair_json(const Vec2& p) {
  return io::Json(std::vector<double>{p.x(), p.y()});
}

io::Json path_json(const std::vector<Vec2>& path) {
  io::Json list = io::Json::array();
  for (const auto& p : path) list.push(pair_json(p));
  return list;
}

// A line and what it is: "route" or "driven".
using Line = std::pair<std::string, std::vector<Vec2>>;

io::Layer route_layer(const std::vector<Line>& lines, const std::string& crs) {
  // Any frame serves to come from the raster's CRS to latitude and longitude.
  const geodesy::LocalFrame zero({0.0, 0.0, 0.0});
  const geodesy::CrsConverter converter(crs, zero);
  io::Layer layer;
  layer.name = "route";
  layer.title = "Route over the costmap";
  layer.kind = io::GeometryKind::line;
  layer.with_heights = false;
  layer.columns = {{"length_m", io::ColumnType::real, "m", "Length of the path"},
                   {"kind", io::ColumnType::text, "", "route: planned; driven: the track of the simulated drive"}};
  for (const auto& [kind, path] : lines) {
    io::Feature feature;
    auto& line = feature.parts.emplace_back().emplace_back();
    for (const auto& p : path) line.push_back(zero.to_geodetic(converter.to_local(geometry::Vec3(p.x(), p.y(), 0.0))));
    feature.values = {ground::length_m(path), kind};
    layer.features.push_back(std::move(feature));
  }
  return layer;
}

// The band called cost, else the first.
const Grid<std::uint8_t>& cost_band(const io::Raster& raster, const std::filesystem::path& path) {
  const io::RasterBand* chosen = raster.bands.empty() ? nullptr : &raster.bands.front();
  for (const auto& band : raster.bands)
    if (band.name == "cost") chosen = &band;
  const auto* cost = chosen == nullptr ? nullptr : std::get_if<Grid<std::uint8_t>>(&chosen->values);
  if (cost == nullptr)
    throw Error(ErrorCode::invalid_input, "not a costmap: the first band is not of bytes")
        .file(path.string())
        .hint("Give the costmap.tif that 'cairn costmap' writes");
  return *cost;
}

io::Json drive_json(const RouteDrive& run) {
  return io::Json::object({{"status", std::string(ground::name_of(run.status))},
                           {"reason", run.reason},
                           {"length_m", run.length_m},
                           {"time_s", run.time_s},
                           {"clearance_m", run.clearance_m},
                           {"cost", run.weighted_length_m},
                           {"collisions", static_cast<std::int64_t>(run.collisions)},
                           {"replans", static_cast<std::int64_t>(run.replans)},
                           {"searches", static_cast<std::int64_t>(run.plans)},
                           {"recoveries", static_cast<std::int64_t>(run.recoveries)},
                           {"expansions", static_cast<std::int64_t>(run.expansions)},
                           {"scans", static_cast<std::int64_t>(run.scans)},
                           {"packets", static_cast<std::int64_t>(run.packets)},
                           {"mean_packet_delay_s", run.mean_delay_s},
                           {"max_packet_delay_s", run.max_delay_s}});
}

// Points of a track at least so far apart, for layers.
std::vector<Vec2> thinned(const std::vector<survey::VehicleState>& track) {
  constexpr double kApart_m = 0.1;
  std::vector<Vec2> points;
  for (const auto& state : track)
    if (points.empty() || (state.position - points.back()).norm() >= kApart_m) points.push_back(state.position);
  if (points.size() == 1) points.push_back(track.back().position);
  return points;
}

RouteDriveInputs drive_inputs(const RouteStageOptions& options) {
  RouteDriveInputs inputs;
  if (!options.hidden.empty()) inputs.hidden = io::read_obstacles(options.hidden).obstacles;
  if (!options.packets.empty()) inputs.packets = io::read_packets(options.packets);
  std::stable_sort(inputs.packets.begin(), inputs.packets.end(),
                   [](const auto& a, const auto& b) { return a.arrival_time_ns < b.arrival_time_ns; });
  return inputs;
}

}  // namespace

Outcome route_stage(const std::filesystem::path& costmap, const std::filesystem::path& out,
                    const RouteStageOptions& options, base::RunContext& ctx) {
  if (!options.drive && (!options.packets.empty() || !options.hidden.empty()))
    throw Error(ErrorCode::invalid_argument, "--packets and --hidden are for --drive").hint("Add --drive");
  const io::Raster raster = io::read_raster(costmap);
  const Grid<std::uint8_t>& cost = cost_band(raster, costmap);
  const auto from = end_of("from", options.from, options.from_local, raster.crs);
  const auto to = end_of("to", options.to, options.to_local, raster.crs);
  if (from.has_value() != to.has_value())
    throw Error(ErrorCode::invalid_argument, "a route needs both ends, or none").hint("Give --from and --to");

  Cell start, goal;
  if (from) {
    start = cell_of(cost, *from, "start");
    goal = cell_of(cost, *to, "goal");
  } else {
    const auto ends = ground::far_apart(cost, options.route);
    if (!ends) throw Error(ErrorCode::failed_precondition, "the costmap has no drivable cell").file(costmap.string());
    start = ends->first;
    goal = ends->second;
  }
  const ground::Route route = ground::find_route(cost, start, goal, options.route, ctx);
  if (!route.found)
    throw Error(ErrorCode::failed_precondition, "there is no route")
        .file(costmap.string())
        .found(route.reason)
        .hint(route.reason == "no_path" ? "Obstacles or unknown ground lie between the ends; try --allow-unknown"
                                        : "Move the end to drivable ground; cells of cost 253 and more are blocked");

  std::vector<Vec2> corners = ground::without_collinear(route.path);
  double length = route.length_m, weighted = route.weighted_length_m;
  if (options.smooth) {
    Grid<std::uint8_t> lethal(cost.geometry, 0);
    for (std::size_t i = 0; i < cost.values.size(); ++i) lethal.values[i] = cost.values[i] == ground::kLethal ? 1 : 0;
    const int reach = std::clamp(static_cast<int>(kFarthest_m / cost.geometry.cell), 1, 32000);
    const auto squared = ground::squared_distance(lethal, reach);
    corners = ground::smoothed(cost, route.path, options.route, &squared);
    length = ground::length_m(corners);
    weighted = ground::weighted_length_m(cost, corners, options.route);
  }
  Outcome outcome;
  outcome.summary = io::Json::object({{"from_m", pair_json(route.path.front())},
                                      {"to_m", pair_json(route.path.back())},
                                      {"ends", from ? "given" : "chosen: far apart in the largest drivable region"},
                                      {"length_m", length},
                                      {"cost", weighted},
                                      {"weighted_length_m", weighted},
                                      {"clearance_m", ground::clearance_m(cost, corners, kFarthest_m)},
                                      {"expansions", static_cast<std::int64_t>(route.expansions)},
                                      {"smoothed", options.smooth}});
  std::vector<Line> lines{{"route", corners}};
  if (options.drive) {
    RouteDriveOptions driving = options.driving;
    driving.driver.route = options.route;
    const RouteDrive run = drive_route(cost, corners, drive_inputs(options), driving, ctx);
    const io::Json figures = drive_json(run);
    const std::vector<Vec2> driven = thinned(run.track);
    io::Json file = figures;
    file.set("path_m", path_json(driven));
    base::write_file(out / "drive.json", file.dump() + "\n");
    io::write_vehicle_csv(out / "drive.csv", run.track);
    outcome.summary.set("drive", figures);
    lines.emplace_back("driven", driven);
  }
  io::Json file = outcome.summary;
  file.set("path_m", path_json(corners));
  base::write_file(out / "route.json", file.dump() + "\n");
  io::write_geojson(out / "route.geojson", route_layer(lines, raster.crs));
  return outcome;
}

}  // namespace cairn::pipeline
