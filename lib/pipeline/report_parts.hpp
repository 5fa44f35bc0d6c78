// Pieces of the report that need more than one file. Internal to the stage `report`.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "base/run_context.hpp"
#include "io/raster.hpp"
#include "pipeline/report_stage.hpp"
#include "report/report_data.hpp"
#include "survey/survey.hpp"

namespace cairn::pipeline {

// rocks.json with the meshes of rocks/<id>.ply.
[[nodiscard]] std::vector<report::RockView> read_rock_views(const ReportInputs& in, base::RunContext& ctx);

// Which triangles of a mesh closed on the plane of the ground were seen: those without a vertex on that plane.
// contact: at least three points of the plane [m]. Empty where that does not explain the unseen share of
// the area (to 0.02), so that nothing wrong is shown.
[[nodiscard]] std::vector<std::uint8_t> seen_triangles(const geometry::TriangleMesh& mesh,
                                                       const std::vector<geometry::Vec3>& contact,
                                                       double unseen_area_fraction);

// coverage.json and gaps.json; histograms from the bands of views.tif where coverage.json has none.
[[nodiscard]] std::optional<report::CoverageView> read_coverage_view(const ReportInputs& in,
                                                                     const survey::Survey& survey,
                                                                     const std::optional<io::Raster>& views);

// Crops of each target's best detections, of different photographs, best score first. Photographs that
// are missing are left out with a warning.
void add_photos(std::vector<report::TargetView>& targets, const survey::Survey& survey,
                const std::filesystem::path& survey_folder, const ReportStageOptions& options, base::RunContext& ctx);

// Mean colour of the cloud's points in each cell; empty where the survey has no cloud with colours.
[[nodiscard]] std::optional<report::ColourView> cloud_colours(const survey::Survey& survey,
                                                              const std::filesystem::path& survey_folder, double cell,
                                                              base::RunContext& ctx);

}  // namespace cairn::pipeline
