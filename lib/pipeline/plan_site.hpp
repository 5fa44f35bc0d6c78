// Where a plan is made: its frame, its surface, its camera, its area.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "geodesy/local_frame.hpp"
#include "planning/area.hpp"
#include "planning/surface_heights.hpp"
#include "survey/manifest.hpp"

namespace cairn::pipeline {

struct PlanCameraOptions {
  // Where no survey gives one: a 20-megapixel camera of 1 inch, 8.8 mm (74 deg across, 53 deg high).
  std::int64_t width_px = 5472, height_px = 3648;
  double focal_px = 3685.0;

  void visit(base::OptionVisitor& v) {
    v.integer("image-width-px", width_px, 16, 100'000, "of the camera, where no survey gives one");
    v.integer("image-height-px", height_px, 16, 100'000, "of the camera, where no survey gives one");
    v.real("focal-px", focal_px, 1.0, 1e6, "focal length of the camera, where no survey gives one");
  }
};

[[nodiscard]] survey::Camera plan_camera(const PlanCameraOptions& options);

// Outer rings and holes of a file (GeoJSON, GeoPackage, Shapefile) on the globe.
struct GeographicArea {
  std::vector<std::vector<geometry::Geodetic>> rings;
  [[nodiscard]] geometry::Geodetic centre() const;  // of the rings' box, height 0
  [[nodiscard]] planning::Area in(const geodesy::LocalFrame& frame) const;
};
// All polygons of all layers. Throws invalid_input where there is none, crs_mismatch where a layer has no CRS.
[[nodiscard]] GeographicArea read_area(const std::filesystem::path& path);

// Surface of a terrain raster or mesh (as `cairn coverage` reads it) as heights; the plane at local up 0 for "".
// cell_m: of a mesh; a raster keeps its own.
[[nodiscard]] planning::SurfaceHeights read_surface_heights(const std::filesystem::path& terrain,
                                                            const geodesy::LocalFrame& frame, double cell_m,
                                                            base::RunContext& ctx);

// "15min", "900s", "0.5h", "900" -> s. Throws invalid_argument.
[[nodiscard]] double parse_duration(const std::string& text);

}  // namespace cairn::pipeline
