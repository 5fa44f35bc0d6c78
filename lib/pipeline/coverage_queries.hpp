// Plain visibility queries of `cairn coverage`: which frames saw a point, what is seen from one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "coverage/coverage.hpp"
#include "io/json.hpp"
#include "pipeline/audited_surface.hpp"
#include "pipeline/coverage_views.hpp"

namespace cairn::pipeline {

// texts: "EAST,NORTH" or "EAST,NORTH,UP", local ENU, m; without UP the point lies `above` [m] the surface straight
// below the sky. Throws invalid_argument for a text that is not two or three finite numbers, invalid_input where there
// is no surface at the place.
[[nodiscard]] std::vector<geometry::Vec3> parse_points(const std::vector<std::string>& texts,
                                                       const AuditedSurface& surface, const visibility::Scene& scene,
                                                       double above);

// points.json: for every point, a row a frame: seen, out_of_frame or occluded, range, pixel, sampling distance.
// The summary: for every point, how many frames saw it.
[[nodiscard]] io::Json answer_points(const std::filesystem::path& out, const std::vector<geometry::Vec3>& points,
                                     const visibility::Scene& scene, const CoverageViews& views,
                                     const coverage::CoverageOptions& options);

// viewshed.csv: facet,seen_from = number of the eyes that see it; with a raster surface in a frame also viewshed.tif:
// band `seen_from`, the least of a cell's facets. The summary: for every eye, the area that is seen from it.
[[nodiscard]] io::Json answer_viewsheds(const std::filesystem::path& out, const std::vector<geometry::Vec3>& eyes,
                                        const AuditedSurface& surface, const visibility::Scene& scene, double end_gap,
                                        base::RunContext& ctx);

}  // namespace cairn::pipeline
