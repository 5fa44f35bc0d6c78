// What the report shows, as plain data. Whoever reads the products of a run fills it; every part
// but the manifest may be empty, and then its section is not there.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "geometry/grid.hpp"
#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"
#include "io/json.hpp"
#include "survey/frame.hpp"
#include "survey/manifest.hpp"
#include "survey/obstacle.hpp"
#include "survey/rock.hpp"
#include "survey/target.hpp"

namespace cairn::report {

struct FrameView {
  survey::Frame frame;
  geometry::Ring footprint;  // outline on the ground, local ENU, m; empty = not known
};

// A photograph, or a part of one, encoded already.
struct Photo {
  std::string caption;     // "DJI_0020.JPG, score 0.91"
  std::string media_type;  // "image/jpeg", "image/png" or "image/webp"; others are refused
  std::string bytes;
};

struct TargetView {
  survey::Target target;
  std::vector<Photo> photos;
};

struct RockView {
  survey::Rock rock;
  std::optional<geometry::TriangleMesh> mesh;  // local ENU, m
  // One value a triangle: 1 = supported by measured points, 0 = closed by the cap model. Empty = not known.
  std::vector<std::uint8_t> facet_seen;
  std::string model_file;  // "rocks/12.glb", shown as text; "" = none
};

// A connected part of the surface that fails the gates.
struct GapView {
  std::int64_t id = 0;
  std::vector<geometry::Ring> rings;  // local ENU, m; even-odd
  geometry::Vec2 centroid = geometry::Vec2::Zero();
  double area_m2 = 0.0;
  std::vector<std::string> reasons;  // codes: "few_views", "oblique", "low_parallax", "occluded", ...
  std::vector<std::string> nearest_frames;
  std::string suggestion;  // one sentence; "" = none
};

// Area of the surface by a per-facet metric.
struct Histogram {
  std::string metric;            // "views"
  std::string title;             // "Views of a facet"
  std::string unit;              // "" = a count
  std::vector<double> edges;     // ascending, one more than areas
  std::vector<double> areas_m2;  // >= 0
  std::optional<double> gate;    // the limit, in `unit`
  bool gate_is_minimum = true;   // values at or above the gate pass; else at or below
};

struct Gate {
  std::string name;  // "views"
  std::string rule;  // "at least 3"
  double pass_fraction = 0.0;
};

// Part of the surface by its verdict: "passed", or why it fails.
struct VerdictArea {
  std::string verdict;
  double area_m2 = 0.0;
};

struct CoverageView {
  std::size_t facets = 0;
  double area_m2 = 0.0;
  double complete_fraction = 0.0;  // of the area, passing all gates
  std::optional<std::array<double, 2>> interval_95;
  std::vector<Gate> gates;
  std::vector<VerdictArea> verdicts;  // in the order they were tested
  std::vector<Histogram> histograms;
  std::vector<GapView> gaps;
  std::optional<std::string> validation;  // one sentence on how the ray casting was checked
};

struct RouteView {
  std::vector<geometry::Vec2> path;  // local ENU, m
  double length_m = 0.0;
  std::optional<double> cost;             // of the planner, in its own unit
  std::optional<double> min_clearance_m;  // least distance to an obstacle's border
  std::string planner;                    // "A*, 8-connected"
};

enum class RasterRole { surface, views, costmap };

// Cells without data are NaN. Heights are in the datum of the survey's origin, not local up.
struct RasterView {
  RasterRole role = RasterRole::surface;
  geometry::Grid<float> grid;
  std::string unit;  // "m", "views", "cost"
};

// Colours of the surface seen from above; mask 0 = no data.
struct ColourView {
  geometry::GridGeometry geometry;
  std::vector<std::array<std::uint8_t, 3>> colours;
  std::vector<std::uint8_t> mask;
};

struct InputFile {
  std::string path, sha256;
};

struct StageReject {
  std::string stage;
  base::Reject reject;
};

struct Provenance {
  std::string version;  // of the program
  std::string recipe;   // "post_flight"
  std::uint64_t seed = 0;
  io::Json options;  // resolved, as in run.json; null = not known
  std::vector<InputFile> inputs;
  std::vector<std::string> crs_operations;
  std::vector<std::string> warnings;
};

struct ReportData {
  survey::Manifest manifest;
  std::vector<FrameView> frames;
  std::size_t detections = 0;
  std::vector<TargetView> targets;          // ascending id
  std::vector<RockView> rocks;              // ascending id; ids are those of targets
  std::vector<survey::Obstacle> obstacles;  // ascending id
  std::optional<CoverageView> coverage;
  std::optional<RouteView> route;
  std::vector<RasterView> rasters;
  std::optional<ColourView> colours;
  std::vector<StageReject> rejects;
  Provenance provenance;
};

}  // namespace cairn::report
