#include "pipeline/coverage_stage.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geodesy/local_frame.hpp"
#include "io/camera_table.hpp"
#include "io/csv.hpp"
#include "io/gaps_json.hpp"
#include "io/raster.hpp"
#include "io/survey_folder.hpp"
#include "io/survey_json.hpp"
#include "pipeline/audited_surface.hpp"
#include "pipeline/coverage_summary.hpp"
#include "pipeline/function_stage.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using coverage::Audit;
using coverage::FacetCoverage;
using geometry::Grid;
using geometry::Vec3;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kMostCells = 1e8;  // of a views.tif laid over a mesh

struct Views {
  coverage::ViewSet set;
  std::optional<survey::Origin> origin;  // empty for a camera table
  std::vector<base::Reject> rejects;
};

Views read_views(const CoverageInputs& in) {
  Views views;
  const bool table = in.format == "pinhole-table" || (in.format == "auto" && !fs::is_directory(in.views));
  if (table) {
    for (const io::TableView& row : io::read_camera_table(in.views)) {
      if (views.set.cameras.empty() || !(views.set.cameras.back() == row.camera))
        views.set.cameras.push_back(row.camera);
      views.set.views.push_back({survey::FrameId(static_cast<std::int64_t>(views.set.views.size())),
                                 views.set.cameras.size() - 1, row.T_world_camera});
    }
    return views;
  }
  const survey::Survey survey = io::read_survey(in.views);
  views.origin = survey.manifest.origin;
  views.set.cameras = survey.manifest.cameras;
  for (const survey::Frame& frame : survey.frames) {
    const auto camera = std::find_if(views.set.cameras.begin(), views.set.cameras.end(),
                                     [&](const survey::Camera& c) { return c.id == frame.camera; });
    if (camera == views.set.cameras.end()) {
      views.rejects.push_back({"frame " + std::to_string(frame.id.value), "camera_missing",
                               "the survey has no camera " + std::to_string(frame.camera.value)});
      continue;
    }
    views.set.views.push_back(
        {frame.id, static_cast<std::size_t>(camera - views.set.cameras.begin()), frame.T_world_camera});
  }
  return views;
}

// The worst of the facets of one cell.
struct CellValues {
  Grid<float> views, gsd, incidence, parallax;

  explicit CellValues(const geometry::GridGeometry& g)
      : views(g, kNone), gsd(g, kNone), incidence(g, kNone), parallax(g, kNone) {}

  void take(std::size_t cell, std::size_t facet, const FacetCoverage& m) {
    const auto least = [cell](Grid<float>& grid, float value) {
      float& v = grid.values[cell];
      v = std::isnan(v) ? value : std::min(v, value);
    };
    const auto largest = [cell](Grid<float>& grid, float value) {
      float& v = grid.values[cell];
      v = std::isnan(v) ? value : std::max(v, value);
    };
    least(views, static_cast<float>(m.views[facet]));
    if (m.views[facet] > 0) {
      largest(gsd, m.gsd_best_mm[facet]);
      largest(incidence, m.incidence_best_deg[facet]);
    }
    // One view has no parallax.
    least(parallax, m.views[facet] > 1 ? m.parallax_deg[facet] : 0.0F);
  }
  void write(const fs::path& path, const std::string& crs) const {
    io::write_cog(path,
                  {{"views", "", "frames that see the facet (predicted visibility)", views, std::nullopt},
                   {"gsd_mm", "mm", "best ground sampling distance", gsd, std::nullopt},
                   {"incidence_deg", "deg", "least angle between sight line and normal", incidence, std::nullopt},
                   {"parallax_deg", "deg", "largest angle between two sight lines", parallax, std::nullopt}},
                  crs);
  }
};

CellValues over_raster(const AuditedSurface& surface, const FacetCoverage& metrics, const Audit& audit) {
  CellValues values(*surface.grid);
  for (std::size_t f = 0; f < surface.facet_cell.size(); ++f)
    if (audit.verdicts[f] != coverage::Verdict::no_data) values.take(surface.facet_cell[f], f, metrics);
  return values;
}

// Looks down on every cell's centre.
CellValues over_mesh(const geometry::TriangleMesh& mesh, const visibility::Scene& scene, const FacetCoverage& metrics,
                     const Audit& audit, double cell) {
  geometry::Box3 box;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (audit.verdicts[i] == coverage::Verdict::no_data) continue;
    const Vec3 c = mesh.centroid(i);
    if (c.allFinite()) box.extend(c);
  }
  if (box.empty()) return CellValues({0.0, cell, cell, 1, 1});
  // A mesh may be of any size: coarser cells where it is large.
  const Vec3 size = box.size();
  const double edge = std::max(cell, std::sqrt(size.x() * size.y() / kMostCells));
  CellValues values(geometry::covering_grid(box.min.head<2>(), box.max.head<2>(), edge));
  const geometry::GridGeometry& g = values.views.geometry;
  std::vector<geometry::Ray> rays(g.columns);
  for (std::size_t r = 0; r < g.rows; ++r) {
    for (std::size_t c = 0; c < g.columns; ++c) {
      const geometry::Vec2 p = g.centre(r, c);
      rays[c] = {Vec3(p.x(), p.y(), box.max.z() + 1.0 + size.z()), -Vec3::UnitZ()};
    }
    const auto hits = scene.cast(rays);
    for (std::size_t c = 0; c < g.columns; ++c)
      if (hits[c].hit() && audit.verdicts[hits[c].triangle] != coverage::Verdict::no_data)
        values.take(r * g.columns + c, hits[c].triangle, metrics);
  }
  return values;
}

// Four decimals: 0.1 um a pixel and 0.36" are finer than any of the figures are good for.
double rounded(float value) {
  constexpr double kSteps = 1e4;
  return std::round(static_cast<double>(value) * kSteps) / kSteps;
}

void write_facets(const fs::path& path, const FacetCoverage& m, const Audit& audit) {
  io::CsvWriter csv(path, {"facet", "views", "in_frame", "facing", "gsd_best_mm", "gsd_median_mm", "incidence_best_deg",
                           "incidence_second_deg", "parallax_deg", "verdict"});
  for (std::size_t i = 0; i < m.views.size(); ++i) {
    csv.cell(static_cast<std::uint64_t>(i))
        .cell(static_cast<std::uint64_t>(m.views[i]))
        .cell(static_cast<std::uint64_t>(m.in_frame[i]))
        .cell(static_cast<std::uint64_t>(m.facing[i]));
    for (const auto* column :
         {&m.gsd_best_mm, &m.gsd_median_mm, &m.incidence_best_deg, &m.incidence_second_deg, &m.parallax_deg})
      csv.cell(rounded((*column)[i]));
    csv.cell(coverage::name_of(audit.verdicts[i])).end_row();
  }
  csv.finish();
}

io::Json definitions() {
  return io::Json::object(
      {{"views", "frames with the facet's centroid inside the image, facing the camera, and nothing between"},
       {"gsd_mm", "square root of the area on the facet's plane that one pixel covers, mm/px; best of the views"},
       {"incidence_deg", "angle between sight line and facet normal, deg; least of the views"},
       {"parallax_deg", "largest angle between two sight lines to the facet, deg"},
       {"completeness", "area of observed facets that pass all gates / area of all observed facets"},
       {"area_m2", "surface area of the observed facets"},
       {"no_data", "facets that were interpolated or closed: never counted as covered"},
       {"kind", "predicted visibility: computed from poses and surface, not from the images"}});
}

}  // namespace

void CoverageStageOptions::visit(base::OptionVisitor& v) {
  visibility.visit(v);
  gates.visit(v);
  gaps.visit(v);
  v.flag("facets-csv", facets_csv, "write facets.csv, a row a facet");
  v.real("raster-cell-m", raster_cell_m, 0.01, 1000.0, "cell of views.tif where the surface is a mesh, m");
}

Outcome coverage_stage(const CoverageInputs& in, const fs::path& out, const CoverageStageOptions& options,
                       base::RunContext& ctx) {
  CoverageStageOptions checked = options;
  checked.visibility.metrics = true;
  base::validate(base::bind_options(checked), "coverage");
  Views views = read_views(in);
  std::optional<geodesy::LocalFrame> frame;
  if (views.origin) frame.emplace(views.origin->position);
  const AuditedSurface surface = read_audited_surface(in.surface, frame);
  for (const auto& note : surface.notes) ctx.warn(in.surface.filename().string() + ": " + note);
  if (views.set.views.empty()) ctx.warn("There are no views: nothing is covered");
  ctx.check_memory(250 * static_cast<std::uint64_t>(surface.mesh.triangles.size()), "coverage");
  ctx.check_stop();

  // The counts are those of a plain Embree loop; see visibility::Tracing.
  const visibility::Scene scene(surface.mesh, visibility::Tracing::fast);
  const FacetCoverage metrics = coverage::coverage(surface.mesh, scene, views.set, checked.visibility, ctx);
  const Audit audit = coverage::audit(surface.mesh, metrics, surface.observed, options.gates);
  const auto gaps = coverage::find_gaps(surface.mesh, audit.verdicts, views.set, options.gaps);
  ctx.check_stop();

  CoverageFigures figures = coverage_figures(surface.mesh, metrics, audit, options.gates);
  io::Json& summary = figures.summary;
  summary.set("frames", views.set.views.size());
  summary.set("gaps", gaps.size());
  double gap_area = 0.0;
  for (const auto& gap : gaps) gap_area += gap.area_m2;
  summary.set("gap_area_m2", gap_area);

  io::Json file = io::Json::object({{"schema_version", 1}});
  if (views.origin) file.set("frame", io::to_json(*views.origin));
  for (const auto& [name, value] : summary.as_object()) file.set(name, value);
  file.set("histograms", figures.histograms);
  file.set("definitions", definitions());
  file.set("validation",
           "Counts and angles of the ray casting equal an independent brute-force caster on test scenes in every facet "
           "away from silhouettes.");
  base::write_file(out / "coverage.json", file.dump() + "\n");
  if (options.facets_csv) write_facets(out / "facets.csv", metrics, audit);
  if (frame) {
    io::write_gaps(out / "gaps.json", {*views.origin, gaps});
    if (surface.grid) {
      over_raster(surface, metrics, audit).write(out / "views.tif", surface.crs);
    } else {
      over_mesh(surface.mesh, scene, metrics, audit, options.raster_cell_m)
          .write(out / "views.tif", frame->raster_crs_wkt());
    }
  }
  return {std::move(summary), std::move(views.rejects)};
}

std::unique_ptr<Stage> make_coverage_stage() {
  return make_function_stage<CoverageStageOptions>(
      {"coverage",
       {"terrain"},
       {},
       [](const StageInputs& in, const CoverageStageOptions&) {
         std::error_code ignored;
         const auto bytes = fs::file_size(in.products / "surface.tif", ignored);
         // Before the surface is there, one of a few million cells is assumed.
         constexpr std::uint64_t kAssumed = std::uint64_t{256} << 20U;
         return ignored ? Estimate{2 * kAssumed, kAssumed / 4} : Estimate{100 * bytes, 8 * bytes};
       },
       [](const StageInputs& in, const fs::path& out, const CoverageStageOptions& options, base::RunContext& ctx) {
         return coverage_stage({in.products / "surface.tif", in.survey, "survey"}, out, options, ctx);
       }});
}

}  // namespace cairn::pipeline
