// Prior map, known ground, obstacles and scans -> costmap (GeoTIFF), ROS map and keep-out mask.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "ground/costmap.hpp"
#include "ground/scan_map.hpp"
#include "ground/terrain_layers.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

// An empty path = there is no such source. A prior map, a surface or an extent has to be there.
struct CostmapInputs {
  std::filesystem::path obstacles;  // obstacles.json, or a vector file with the layer `obstacles` (GeoPackage, GeoJSON)
  std::filesystem::path surface;    // GeoTIFF of heights: free where one is known, unknown elsewhere
  std::filesystem::path prior;      // ROS map (.yaml), GeoTIFF, or polygons (.gpkg, .geojson, .shp)
  std::filesystem::path scans;      // lidar.csv, with
  std::filesystem::path vehicle;    // vehicle.csv
  std::filesystem::path survey;     // survey folder that names the local frame where no other source does
};

struct CostmapStageOptions {
  ground::CostmapOptions cost;
  ground::CombineOptions combine;
  ground::ScanMapOptions scans;
  ground::TerrainLayerOptions terrain;
  bool terrain_layers = false;      // judge the surface's slope, roughness and steps
  std::string extent;               // WEST,SOUTH,EAST,NORTH of the map, local m; "" = that of the prior map or surface
  double prior_occupied_from = 50;  // values of a prior raster that are obstacles (0..100 or 0..254)
  // What lies in no polygon of a prior map, or in a map without prior map and surface: free, unknown, occupied.
  std::string outside = "auto";
  bool accept_yaw = false;           // a turned ROS map is resampled instead of refused
  std::string map_mode = "trinary";  // of the ROS map: trinary, scale, raw
  double keepout_inflate_m = 0.0;    // Nav2 does not inflate a keep-out mask
  double max_log_gap_s = 0.5;        // in vehicle.csv, that may be bridged
  double max_tilt_deg = 5.0;         // of the vehicle; beyond it a level scanner sees the ground
  std::int64_t strip_rows = 0;       // rows computed at once; 0 = by memory. The products do not depend on it

  void visit(base::OptionVisitor& v) {
    cost.visit(v);
    combine.visit(v);
    scans.visit(v);
    terrain.visit(v);
    v.flag("terrain-layers", terrain_layers, "judge slope, roughness and steps of the surface; writes terrain.tif");
    v.text("extent", extent, "WEST,SOUTH,EAST,NORTH of the map in local metres");
    v.real("prior-occupied-from", prior_occupied_from, -1e9, 1e9,
           "values of a prior raster from here on are obstacles");
    v.choice("outside", outside, {"auto", "free", "unknown", "occupied"},
             "what lies in no polygon of the prior map; auto: free, but unknown where some polygons are free ground "
             "and where there is no prior map");
    v.flag("accept-yaw", accept_yaw, "resample a turned ROS map instead of refusing it");
    v.choice("map-mode", map_mode, {"trinary", "scale", "raw"}, "mode of the ROS map: obstacles, or graded cost");
    v.real("keepout-inflate-m", keepout_inflate_m, 0.0, 100.0, "grow the keep-out mask by this");
    v.real("max-log-gap-s", max_log_gap_s, 0.001, 1e6, "longest gap of the vehicle's log that may be bridged");
    v.real("max-tilt-deg", max_tilt_deg, 0.0, 90.0, "scans of a vehicle that leans more are left out");
    v.integer("strip-rows", strip_rows, 0, 1'000'000, "rows computed at once; 0 = by memory");
  }
};

// Every file that the stage will read, a ROS map's image and sidecar included. Throws not_found, or invalid_input for a
// YAML that is no map.
[[nodiscard]] std::vector<std::filesystem::path> costmap_files(const CostmapInputs& in);

// Writes costmap.tif (bands `cost` by paper B's equation (9), `occupancy` 0/100, and one for each source; all 255 =
// unknown), map.pgm or .png + map.yaml, keepout.pgm + keepout.yaml + keepout_params.yaml, map.georeference.json and
// keepout.georeference.json; with terrain layers also terrain.tif. Cells keep the north-western corner of the prior map
// or surface. Computed strip by strip with exact seams. Maps of up to 2^26 cells are a COG; larger ones a tiled GeoTIFF
// without overviews, written as it is computed; above 2^31 cells there are no ROS maps.
// Throws crs_mismatch where the sources lie in different frames.
Outcome costmap_stage(const CostmapInputs& in, const std::filesystem::path& out, const CostmapStageOptions& options,
                      base::RunContext& ctx);

}  // namespace cairn::pipeline
