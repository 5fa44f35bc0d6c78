// Costmap -> route.
#pragma once

#include <filesystem>
#include <string>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "ground/route.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/route_drive.hpp"

namespace cairn::pipeline {

struct RouteStageOptions {
  ground::RouteOptions route;
  // Ends, as "LAT,LON" in degrees or "EAST,NORTH" in metres of the costmap's frame. Where none is given,
  // two ends far apart in the largest drivable region are taken, and the summary says so.
  std::string from, to;
  std::string from_local, to_local;
  bool smooth = false;  // straighten the path (ground/path.hpp); its clearance and weighted length get no worse
  // Drive the route in simulation (pipeline/route_drive.hpp), with late packets and obstacles that nobody knew.
  bool drive = false;
  std::string packets, hidden;  // packets.bin; obstacles.json
  RouteDriveOptions driving;

  void visit(base::OptionVisitor& v) {
    route.visit(v);
    v.text("from", from, "start as LAT,LON in degrees");
    v.text("to", to, "goal as LAT,LON in degrees");
    v.text("from-local", from_local, "start as EAST,NORTH in metres of the local frame");
    v.text("to-local", to_local, "goal as EAST,NORTH in metres of the local frame");
    v.flag("smooth", smooth, "straighten the path where that brings it no nearer to obstacles");
    v.flag("drive", drive, "drive the route in simulation, with scans and late packets");
    v.text("packets", packets, "with --drive: packets.bin, replayed by their arrival times");
    v.text("hidden", hidden, "with --drive: obstacles.json of what stands there but not in the costmap");
    driving.visit(v);
  }
};

// Reads the band `cost`, or the first, of a costmap. Writes route.json: ends, path (corner points, local ENU), length,
// weighted length, clearance to the nearest obstacle cell, expansions; and route.geojson for maps. With `drive` also
// drive.csv (the true track, as io/vehicle_csv.hpp) and drive.json (its figures and the path driven), and the summary
// has the figures under `drive`. Throws failed_precondition where an end lies outside the map, in an obstacle or
// unknown ground, or no path joins them.
Outcome route_stage(const std::filesystem::path& costmap, const std::filesystem::path& out,
                    const RouteStageOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
