// Parallel lanes over an area: the search and survey pattern.
#pragma once

#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "planning/area.hpp"
#include "planning/surface_heights.hpp"
#include "survey/camera.hpp"
#include "survey/mission.hpp"

namespace cairn::planning {

struct LawnmowerOptions {
  double gsd_m = 0.0;            // ground sampling distance on the optical axis, m/px; 0 = from height_m
  double height_m = 0.0;         // above the surface; 0 = from gsd_m
  double front_overlap = 0.8;    // of successive images of a lane
  double side_overlap = 0.7;     // of neighbouring lanes
  double pitch_deg = -90.0;      // of the camera; -90 looks straight down
  double azimuth_deg = -1.0;     // of the lanes, clockwise from north; negative = along the area's narrowest direction
  std::string heading = "lane";  // lane: the camera looks along each lane; fixed: always along the first
  std::string border = "full";   // full: the overlap holds up to the border; cover: the border is just seen
  bool cross_hatch = false;      // a second set of lanes across the first
  bool follow_terrain = false;   // height above the surface below each image, else one level (paper A, A21)
  double max_climb_deg = 20.0;   // slope of a lane that follows the terrain
  double clearance_m = 5.0;      // least height above the highest point near the path
  double clearance_radius_m = 5.0;

  void visit(base::OptionVisitor& v) {
    v.real("gsd", gsd_m, 0.0, 10.0, "ground sampling distance on the optical axis, m/px; 0 = from --height-m");
    v.real("height-m", height_m, 0.0, 500.0, "height above the surface; 0 = from --gsd");
    v.real("front-overlap", front_overlap, 0.0, 0.95, "overlap of successive images, fraction");
    v.real("side-overlap", side_overlap, 0.0, 0.95, "overlap of neighbouring lanes, fraction");
    v.real("gimbal-pitch-deg", pitch_deg, -90.0, -20.0, "camera against the horizon; -90 looks straight down");
    v.real("azimuth-deg", azimuth_deg, -1.0, 360.0, "direction of the lanes; -1 = where the area is narrowest across");
    v.choice("heading", heading, {"lane", "fixed"}, "camera looks along each lane, or always along the first");
    v.choice("border", border, {"full", "cover"}, "keep the overlap up to the area's border, or just see the border");
    v.flag("cross-hatch", cross_hatch, "fly a second set of lanes across the first");
    v.flag("follow-terrain", follow_terrain, "keep the height above the surface along the lanes");
    v.real("max-climb-deg", max_climb_deg, 1.0, 60.0, "steepest lane that follows the terrain");
  }
};

// How often the area is seen: sample points a fifth of the image spacing apart, by projection (no occlusion).
struct OverlapFigures {
  std::size_t points = 0;
  std::size_t unknown = 0;    // where the surface has no height
  std::size_t uncovered = 0;  // in no image
  std::size_t least = 0;      // images of the point seen least
  std::size_t first_percentile = 0;
  std::size_t median = 0;
  double coarsest_gsd_m = 0.0;  // vertical range / focal length at the lowest point
};

struct LawnmowerPlan {
  std::vector<survey::Waypoint> waypoints;  // without times
  std::vector<survey::Frame> views;         // poses; time_ns = 0
  std::vector<std::size_t> view_waypoint;   // for each view the waypoint after which it is taken (or at which)
  double height_m = 0.0;                    // above the reference of the surface
  double footprint_along_m = 0.0, footprint_across_m = 0.0;  // that the spacing was made for
  double image_spacing_m = 0.0, lane_spacing_m = 0.0;        // largest used
  std::size_t lanes = 0;
  std::size_t wanted_views = 1;  // of each point, by the overlaps
  OverlapFigures overlap;
  std::vector<std::string> notes;
};

// Lanes so far apart that overlap or more is kept (the number is rounded up: no strip is left, D25), over every part of
// the area that a lane's swath touches; footprints from the camera's own rays on the plane at the 98th percentile of
// the surface; then the overlap is counted on the surface, and the spacing shrunk by 5 % until every point is seen and
// 99 % of them as often as wanted (at most 20 times). With a pitch the footprint lies ahead of the camera and is as
// wide as its near edge; rays above 75 deg from the vertical are not counted.
// level: one height: the 2nd percentile of the surface + height_m, raised where the clearance asks for it (noted).
// Image rows lie across the lanes. Throws invalid_input for an unsound area (check_area) or one without known surface,
// invalid_argument where neither or both of gsd and height are given, or a camera that cannot see the ground.
[[nodiscard]] LawnmowerPlan plan_lawnmower(const Area& area, const survey::Camera& camera,
                                           const SurfaceHeights& surface, const LawnmowerOptions& options,
                                           base::RunContext& ctx);

// How often points of the area are seen by views, each point at its surface height.
[[nodiscard]] OverlapFigures count_overlap(const Area& area, const std::vector<survey::Frame>& views,
                                           const survey::Camera& camera, const SurfaceHeights& surface, double step);

}  // namespace cairn::planning
