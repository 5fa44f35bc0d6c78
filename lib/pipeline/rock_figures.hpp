// Figures of each rock beside its results: sections, side views, what dominates the uncertainty, photographs with the
// contact line.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/rock_results.hpp"
#include "survey/contact.hpp"
#include "survey/survey.hpp"

namespace cairn::pipeline {

struct FigureOptions {
  std::int64_t photos = 3;      // of each rock, from different sides where there are such
  std::int64_t photo_px = 560;  // side of a photograph's part
  std::int64_t view_px = 260;   // longer side of a shaded view
  double photo_margin = 0.25;   // around the rock, in its longer side

  void visit(base::OptionVisitor& visitor);
};

// A frame that shows a rock, best first.
struct RockPhoto {
  survey::FrameId frame;
  geometry::PixelBox box;            // of the mesh's vertices, in the camera's pixels
  std::vector<std::uint8_t> hidden;  // a flag a vertex of the contact: the rock itself stands before it
  double azimuth_deg = 0.0;          // the camera looks this way, level part
  double contact_in_sight = 0.0;     // share of the contact's vertices, 0..1
};

// Frames whose image holds the whole mesh, at least 24 pixels across; ordered by size in pixels times (0.2 + contact in
// sight), then thinned so that the first ones differ by 40 deg in azimuth where that is possible. The mesh is the only
// thing that can hide a point: other rocks and terrain are not asked.
[[nodiscard]] std::vector<RockPhoto> rock_photos(const geometry::TriangleMesh& mesh, const survey::Contact& contact,
                                                 const survey::Survey& survey, std::size_t count);

// Writes <stem>_sections.svg and <stem>_views.svg for rocks that can be measured, <stem>_uncertainty.svg where there
// are draws, and with a survey <stem>_photo_<n>.svg for every rock with a mesh; uncertainty.csv over all rocks
// (rock_id,name,source,variance_share_of_alpha). Contact lines: <id>.json of `input` where it is a surface folder, else
// the support polygon. survey_folder: "" = none; rocks must then stand in its local frame. Photographs that cannot be
// read are warned of and left out. Summary "figures": counts by kind.
Outcome figure_files(const std::vector<RockResult>& results, const std::filesystem::path& input,
                     const std::filesystem::path& survey_folder, const std::filesystem::path& out,
                     const FigureOptions& options, base::RunContext& ctx);

}  // namespace cairn::pipeline
