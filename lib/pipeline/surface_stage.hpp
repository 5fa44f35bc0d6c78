// Stage `surface`: labelled cloud -> closed mesh and mass properties per rock.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "geometry/point_cloud.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"
#include "surface/rock_body.hpp"

namespace cairn::pipeline {

struct SurfaceOptions {
  double ground_width_m = 1.25;  // terrain points up to this far beyond the rock carry the ground plane
  surface::BodyOptions body;

  void visit(base::OptionVisitor& visitor);
};

// Class by target id, where known (segments.json); else "rock".
using RockClasses = std::map<std::int64_t, std::string>;

// One mesh a rock into `folder`: <id>.ply (double), <id>.glb (float about its own origin), <id>.json
// {"schema_version", "frame", "rock": record as in rocks.json without tipping, "surface": {method, quality, ground,
// ...}, "contact": {assumed, points: [{position_m, status}]}}. Rocks without a body get their <id>.json with the
// reason. `frame_text`: one sentence on the coordinates. The base is closed on the plane of the terrain around the
// rock; without terrain points on a level plane at the lowest rock point (note ground_assumed_level).
[[nodiscard]] Outcome surface_rocks(const geometry::PointCloud& labelled, const RockClasses& classes,
                                    const std::string& frame_text, const std::filesystem::path& folder,
                                    const SurfaceOptions& options, base::RunContext& ctx);

// `cairn surface`. Coordinates must be metres (a CRS in feet or degrees throws crs_mismatch).
[[nodiscard]] Outcome surface_file(const std::filesystem::path& labelled, const std::filesystem::path& folder,
                                   const SurfaceOptions& options, base::RunContext& ctx);

// The recipe's stage: labelled.las, segments.json -> rocks/<id>.{ply,glb,json}.
[[nodiscard]] std::unique_ptr<Stage> make_surface_stage();

}  // namespace cairn::pipeline
