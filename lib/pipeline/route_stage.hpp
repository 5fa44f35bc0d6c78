// Costmap -> route.
#pragma once

#include <filesystem>
#include <string>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "ground/route.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

struct RouteStageOptions {
  ground::RouteOptions route;
  // Ends, as "LAT,LON" in degrees or "EAST,NORTH" in metres of the costmap's frame. Where none is given,
  // two ends far apart in the largest drivable region are taken, and the summary says so.
  std::string from, to;
  std::string from_local, to_local;

  void visit(base::OptionVisitor& v) {
    route.visit(v);
    v.text("from", from, "start as LAT,LON in degrees");
    v.text("to", to, "goal as LAT,LON in degrees");
    v.text("from-local", from_local, "start as EAST,NORTH in metres of the local frame");
    v.text("to-local", to_local, "goal as EAST,NORTH in metres of the local frame");
  }
};

// Writes route.json: ends, path (corner points, local ENU), length, weighted length, clearance to the nearest
// obstacle cell, expansions; and route.geojson for maps. Throws failed_precondition where an end lies
// outside the map, in an obstacle or unknown ground, or no path joins them.
Outcome route_stage(const std::filesystem::path& costmap, const std::filesystem::path& out,
                    const RouteStageOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
