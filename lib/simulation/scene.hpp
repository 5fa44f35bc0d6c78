// Description of a survey to simulate, as plain data. docs/formats/scene.md is its text form.
// World = local ENU, metres. Azimuths: degrees clockwise from north.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/geodetic.hpp"
#include "geometry/grid.hpp"
#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"
#include "simulation/drive_spec.hpp"
#include "simulation/render.hpp"
#include "simulation/sampled_cloud.hpp"
#include "simulation/shape.hpp"
#include "survey/camera.hpp"

namespace cairn::simulation {

// fractal: sum of octaves of value noise on a slope; grid: heights given at cell centres; mesh: any surface.
enum class TerrainKind { fractal, grid, mesh };

struct Terrain {
  TerrainKind kind = TerrainKind::fractal;
  // Of kind fractal. Extent east-north [m], max > min; spacing of the vertices [m, > 0].
  geometry::Vec2 min{-50.0, -50.0}, max{50.0, 50.0};
  double cell_m = 0.5;
  double base_up_m = 0.0;                      // height of the slope at (0, 0)
  double slope_east = 0.0, slope_north = 0.0;  // rise per metre
  double relief_m = 0.0;                       // highest less lowest of the noise, >= 0; 0 = a plane
  double wavelength_m = 40.0;                  // of the coarsest octave, > 0
  double roughness = 0.4;                      // amplitude of an octave relative to the coarser one, 0..1
  std::uint64_t seed = 1;                      // of the noise; the run's seed does not change the ground
  // Of kind grid: m, local up; NaN = no ground there.
  geometry::Grid<float> heights;
  // Of kind mesh: local ENU, facing up; a point's ground is the highest surface above it.
  geometry::TriangleMesh mesh;
  std::string material = "gravel";  // of material_names()
};

// Where copies of an object stand.
struct Scatter {
  std::int64_t count = 1;      // >= 1
  geometry::Ring area;         // simple polygon, local east-north, m
  double spacing_m = 1.0;      // least distance between centres of this and all earlier objects, >= 0
  double size_share_lo = 1.0;  // each copy is scaled by a factor drawn uniformly between the two, > 0
  double size_share_hi = 1.0;
  double max_slope_deg = 90.0;  // of the ground under it, 0..90
};

struct ObjectSpec {
  std::string name;          // "" = class and number
  std::string object_class;  // what a perfect detector calls it
  bool sought = false;       // the survey is flown for it; else a distractor
  ShapeSpec shape;
  std::string material;    // of material_names(); "" = granite, of trees foliage
  std::uint64_t seed = 0;  // of an irregular shape and of the scatter: the run's seed changes neither
  // One of the two. `position` is east-north; `up_m` set = the foot stands there, unset = it rests on the ground:
  // no part of its base is above the ground.
  std::optional<geometry::Vec2> position;
  std::optional<double> up_m;
  std::optional<Scatter> scatter;
  double sink_m = 0.0;  // deeper into the ground, m, >= 0
};

// How the camera sits on the vehicle, which flies level (A25: roll and pitch neglected).
struct Mount {
  double gamma_deg = 60.0;  // camera axis below the horizon, 0..90; 90 looks straight down
  double yaw_deg = 0.0;     // camera axis clockwise from the vehicle's heading
};

// One estimation circle about an object, flown when the search has seen it (papers A22, A26).
struct EstimationCircles {
  double seen_s = 3.0;         // the search goes on until the object's centre was this long in view, s, >= 0
  double gamma_0_deg = 45.0;   // from the object's centre up to the vehicle, 0 < gamma_0 < 90: gives the radius
  double turns = 1.0;          // > 0
  bool clockwise = false;      // seen from above
  bool record_transit = true;  // the straight ways there and back
};

enum class FlightKind { lawn_mower, orbit, waypoints };
// world: height_m is local up; mean_ground: above the mean ground of the flight's area (for an orbit: above the ground
// at its centre); ground: above the ground below, wherever the vehicle is.
enum class HeightReference { world, mean_ground, ground };

struct Flight {
  FlightKind kind = FlightKind::lawn_mower;
  std::string camera;  // name of a camera; "" = the first
  double height_m = 20.0;
  HeightReference height_reference = HeightReference::world;
  double speed_m_s = 1.0;         // > 0
  double turn_rate_deg_s = 45.0;  // yaw on the spot, > 0
  // Capture: a rate in time (video), or by distance along straight and curved parts (photographs). Exactly one > 0.
  double rate_hz = 5.0;
  double photo_spacing_m = 0.0;
  std::optional<double> gamma_deg;    // camera axis below the horizon for this flight; unset = the mount's
  std::optional<double> heading_deg;  // fixed heading; unset = along the track (orbit: towards the centre)
  bool record_transit = false;        // the way from where the previous flight ended

  // lawn_mower: parallel lanes that cover the polygon. Lane spacing is given, or follows from side_overlap of the
  // image's width on level ground. First lane where start = lowest side.
  geometry::Ring area;
  double lane_azimuth_deg = 0.0;
  double lane_spacing_m = 0.0;  // > 0, or 0 = from side_overlap
  double side_overlap = 0.6;    // 0..0.95
  std::optional<EstimationCircles> circles;

  // orbit: about a place or an object by its name. radius_m 0 = height over the centre / tan(gamma_0).
  std::string about;
  geometry::Vec3 centre = geometry::Vec3::Zero();
  double radius_m = 0.0;
  double gamma_0_deg = 45.0;
  double turns = 1.0;
  bool clockwise = false;
  bool aim_at_centre = false;  // the camera's axis meets the centre; false = gamma_deg

  // waypoints: local ENU; z is added to the height reference, height_m is not used.
  std::vector<geometry::Vec3> waypoints;
};

// Errors of recorded poses. All sigmas are of one axis.
struct PoseNoise {
  double white_xy_m = 0.0, white_z_m = 0.0;              // drawn anew for each frame
  double constant_xy_m = 0.0, constant_z_m = 0.0;        // drawn once
  double walk_xy_m_sqrt_s = 0.0, walk_z_m_sqrt_s = 0.0;  // random walk, m per square root of a second
  double attitude_deg = 0.0;                             // about each camera axis, stationary
  double attitude_correlation_s = 0.0;  // time constant of it (first-order Gauss-Markov); 0 = drawn for each frame
  double attitude_constant_deg = 0.0;   // about each camera axis, drawn once (a mount that is not quite straight)
};

// Places that a detector takes for an object again and again.
struct Clutter {
  std::int64_t count = 1;                  // >= 1; 1 with `position`
  std::optional<geometry::Vec2> position;  // else drawn uniformly in `area` for each run's seed
  geometry::Ring area;
  double size_m = 1.0;                // diameter of the sphere on the ground whose outline is boxed, > 0
  double hit_probability = 0.3;       // in each frame that shows it whole, from inside its sector, 0..1
  double sector_deg = 360.0;          // width of the azimuths from which it deceives, 0 < s <= 360
  std::optional<double> azimuth_deg;  // middle of that sector, from the place to the camera; unset = drawn
  std::string object_class;           // "" = the first sought class
};

struct Detector {
  double jitter_px = 0.0;             // sigma of each edge
  double jitter_share = 0.0;          // and of the box's width or height, added in squares
  double miss_rate = 0.0;             // 0..1, of objects that can be detected
  double miss_run_frames = 1.0;       // mean length of a run of misses, >= 1 / (1 - miss_rate)
  double min_visible_share = 0.5;     // less of the outline visible = not detected
  double min_inside_share = 0.5;      // less of the outline's box in the image = not detected
  double min_size_px = 6.0;           // of the shorter side
  std::vector<std::string> blind_to;  // classes that it was not trained for: never detected
  double false_per_image = 0.0;       // mean number of sporadic false boxes (Poisson)
  double false_size_lo_px = 15.0, false_size_hi_px = 80.0;
  double score_mean = 0.8, score_sigma = 0.1;               // of boxes of objects, kept in 0.05..1
  double false_score_mean = 0.5, false_score_sigma = 0.15;  // of false ones
  std::vector<Clutter> clutter;
};

// What a distractor is taken for.
struct Confusion {
  std::string of, as;      // classes
  double probability = 0;  // each box of class `of` is called `as` with it, 0..1
};

// What is recorded beside the tables.
struct Products {
  bool images = false, depth = false, masks = false;
  std::string image_format = "jpg";  // "jpg" or "png"
  RenderOptions render;              // `image` is ignored: see `images`
  Lighting lighting;
  DepthNoise depth_noise;
  std::optional<CloudOptions> cloud;  // a labelled cloud of the surface that the flight saw
  std::int64_t cloud_views = 200;     // frames, evenly chosen, that the cloud is seen from, >= 1; 0 = from everywhere
  bool meshes = true;                 // truth/meshes and the terrain's mesh
};

struct Scene {
  std::string name;
  std::string description;
  geometry::Geodetic origin{33.8, -111.9, 700.0};  // ellipsoidal height
  Terrain terrain;
  std::vector<ObjectSpec> objects;
  std::vector<survey::Camera> cameras;  // ids 1..n in order; at least one
  Mount mount;
  std::vector<Flight> flights;  // flown one after the other; at least one
  PoseNoise pose_noise;
  Detector detector;
  std::vector<Confusion> confusions;
  Products products;
  std::optional<DriveSpec> drive;  // a ground vehicle; drawn only by a drive (drive_rehearsal.hpp)
};

// Paper A's camera (R200 as in its simulator): 640x480, hfov 80 deg, fx = fy = 381.36 px.
[[nodiscard]] survey::Camera r200_camera();

// Throws invalid_argument naming the member ("flights[0].speed_m_s"), its value and what is allowed.
void validate(const Scene& scene);

}  // namespace cairn::simulation
