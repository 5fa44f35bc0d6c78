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
#include "survey/contact.hpp"

namespace cairn::pipeline {

struct SurfaceOptions {
  double ground_width_m = 1.25;  // terrain points up to this far beyond the rock carry the ground plane
  surface::BodyOptions body;

  void visit(base::OptionVisitor& visitor);
};

// By target id, where known: class (segments.json), else "rock"; contact line in the cloud's coordinates.
using RockClasses = std::map<std::int64_t, std::string>;
using RockContacts = std::map<std::int64_t, survey::Contact>;

// One mesh a rock into `folder`: <id>.ply (double; unseen parts in another colour), <id>.glb (float about its own
// origin), <id>.json {"schema_version", "frame", "rock": record as in rocks.json without tipping, "surface": {method,
// cap: {model, h_c_m}, noise_m, quality, ground, ...}, "contact": {assumed, line: [{pad, order, position_m, status,
// sigma_m, closed}]}}. Rocks without a body get their <id>.json with the reason. `frame_text`: one sentence on the
// coordinates. The base is closed on the contact line: the one given, where it lies near the rock (else note
// contact_outside_rock), else the one that points labelled as basal contact show; without, on the plane of the terrain
// around the rock; without terrain points on a level plane at the lowest rock point (note ground_assumed_level).
[[nodiscard]] Outcome surface_rocks(const geometry::PointCloud& labelled, const RockClasses& classes,
                                    const RockContacts& contacts, const std::string& frame_text,
                                    const std::filesystem::path& folder, const SurfaceOptions& options,
                                    base::RunContext& ctx);

// `cairn surface`. Coordinates must be metres (a CRS in feet or degrees throws crs_mismatch). `contact`: contact.csv;
// "" = <labelled without extension>.contact.csv where that exists. Throws crs_mismatch where it is in another frame.
struct SurfaceFiles {
  std::filesystem::path labelled, contact;
};
[[nodiscard]] std::filesystem::path contact_file(const SurfaceFiles& in);  // the file that counts, or ""
[[nodiscard]] Outcome surface_file(const SurfaceFiles& in, const std::filesystem::path& folder,
                                   const SurfaceOptions& options, base::RunContext& ctx);

// The recipe's stage: labelled.las, segments.json, contact.csv (where there is one) -> rocks/<id>.{ply,glb,json}.
[[nodiscard]] std::unique_ptr<Stage> make_surface_stage();

}  // namespace cairn::pipeline
