#include "pipeline/terrain_stage.hpp"

#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include "base/parallel.hpp"
#include "geodesy/local_frame.hpp"
#include "geometry/grid_mesh.hpp"
#include "io/ply.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"
#include "io/vector_layer.hpp"
#include "pipeline/function_stage.hpp"
#include "pipeline/survey_sources.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Grid;

// Local up -> height in the origin's datum (the Earth curves away from the tangent plane).
Grid<float> datum_heights(const Grid<float>& up, const geodesy::LocalFrame& frame) {
  Grid<float> heights = up;
  const geometry::GridGeometry& g = up.geometry;
  base::parallel_for(g.rows, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t r = begin; r < end; ++r)
      for (std::size_t c = 0; c < g.columns; ++c) {
        const float h = up.at(r, c);
        if (!std::isfinite(h)) continue;
        const geometry::Vec2 p = g.centre(r, c);
        heights.at(r, c) =
            static_cast<float>(frame.to_geodetic(geometry::Vec3(p.x(), p.y(), static_cast<double>(h))).height_m);
      }
  });
  return heights;
}

template <typename T>
Grid<float> where_known(const Grid<T>& values, const Grid<float>& surface) {
  Grid<float> result(values.geometry, std::nanf(""));
  for (std::size_t k = 0; k < values.values.size(); ++k)
    if (std::isfinite(surface.values[k])) result.values[k] = static_cast<float>(values.values[k]);
  return result;
}

Estimate estimate(const StageInputs& in, const segmentation::TerrainOptions&) {
  const auto survey = io::read_survey(in.survey);
  if (!has_cloud(survey)) return {};
  std::error_code ignored;
  const auto bytes =
      std::filesystem::file_size(io::resolve_reference(survey.source("cloud")->path, in.survey), ignored);
  // A point of some 30 bytes on disk becomes 80 in memory; the grids are smaller than the cloud.
  return ignored ? Estimate{} : Estimate{6 * bytes, 2 * bytes};
}

}  // namespace

Outcome terrain_stage(const TerrainInputs& in, const std::filesystem::path& out,
                      const segmentation::TerrainOptions& options, base::RunContext& ctx) {
  const survey::Survey survey = io::read_survey(in.survey);
  const survey::Origin& origin = survey.manifest.origin;
  const geodesy::LocalFrame frame(origin.position);
  const SurveyCloud loaded = load_cloud(in.survey, survey, ctx);
  const segmentation::TerrainModel model = segmentation::model_terrain(loaded.cloud.positions, options, ctx);
  ctx.check_stop();

  const std::string datum = io::height_type_text(origin.height_type, origin.geoid);
  io::write_cog(
      out / "surface.tif",
      {{"surface", "m", "highest points of each cell, " + datum + " height", datum_heights(model.surface, frame),
        std::nullopt},
       {"ground", "m", "bare ground, " + datum + " height", datum_heights(model.ground, frame), std::nullopt},
       {"observed", "", "1 = from points of this cell, 0 = interpolated", where_known(model.observed, model.surface),
        std::nullopt},
       {"points", "", "points of the cloud in the cell", where_known(model.points, model.surface), std::nullopt}},
      frame.raster_crs_wkt());
  const geometry::GridMesh mesh = geometry::grid_mesh(model.surface);
  io::write_ply(out / "surface.ply", mesh.mesh,
                {"", {"surface model, local east north up in metres about the origin of the survey"}});

  std::size_t observed = 0;
  for (const auto flag : model.observed.values) observed += flag;
  const geometry::GridGeometry& g = model.surface.geometry;
  Outcome outcome;
  outcome.summary = io::Json::object({{"points", loaded.cloud.size()},
                                      {"points_not_finite", model.not_finite},
                                      {"columns", g.columns},
                                      {"rows", g.rows},
                                      {"cell_m", g.cell},
                                      {"cells_observed", observed},
                                      {"cells_interpolated", model.interpolated},
                                      {"cells_empty", g.cells() - observed - model.interpolated},
                                      {"spikes", model.spikes},
                                      {"facets", mesh.mesh.triangles.size()},
                                      {"height_type", datum},
                                      {"crs_operation", loaded.operation}});
  return outcome;
}

std::unique_ptr<Stage> make_terrain_stage() {
  return make_function_stage<segmentation::TerrainOptions>(
      {"terrain",
       {},
       {},
       estimate,
       [](const StageInputs& in, const std::filesystem::path& out, const segmentation::TerrainOptions& options,
          base::RunContext& ctx) { return terrain_stage({in.survey}, out, options, ctx); },
       [](const StageInputs& in) -> std::string {
         return io::read_survey(in.survey).source("cloud") == nullptr ? "a cloud" : "";
       }});
}

}  // namespace cairn::pipeline
