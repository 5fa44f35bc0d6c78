#include "pipeline/coverage_stage.hpp"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "coverage/large_facets.hpp"
#include "geodesy/local_frame.hpp"
#include "io/gaps_json.hpp"
#include "io/survey_json.hpp"
#include "io/vector_layer.hpp"
#include "pipeline/audited_surface.hpp"
#include "pipeline/coverage_frames.hpp"
#include "pipeline/coverage_products.hpp"
#include "pipeline/coverage_queries.hpp"
#include "pipeline/coverage_raster.hpp"
#include "pipeline/coverage_summary.hpp"
#include "pipeline/coverage_tables.hpp"
#include "pipeline/coverage_targets.hpp"
#include "pipeline/coverage_views.hpp"
#include "pipeline/function_stage.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using coverage::Audit;
using coverage::FacetCoverage;

constexpr std::size_t kMostPieces = 4'000'000;  // that cut facets may come to, beside those of the surface

io::Json definitions() {
  return io::Json::object(
      {{"views", "frames with the facet's centroid inside the image, facing the camera, and nothing between"},
       {"gsd_mm", "square root of the area on the facet's plane that one pixel covers, mm/px; best of the views"},
       {"incidence_deg", "angle between sight line and facet normal, deg; least of the views"},
       {"parallax_deg", "largest angle between two sight lines to the facet, deg"},
       {"incidence_median_deg", "angle between sight line and facet normal, deg; lower median of the views"},
       {"parallax_second_deg", "second largest of the angles between two sight lines, all pairs, deg"},
       {"azimuth_bins", "30-degree bins of the views' azimuth about the facet that hold a view, 0 to 12"},
       {"sigma_max_mm", "predicted standard deviation of the facet's position along the direction known worst, mm"},
       {"sigma_z_mm", "the same, up, mm"},
       {"overlap", "frames that have the place inside, whatever stands between: the classical 2.5-D overlap"},
       {"sides", "facets whose unit normal rises by less than 0.2: walls and undersides"},
       {"completeness", "area of observed facets that pass all gates / area of all observed facets"},
       {"area_m2", "surface area of the observed facets"},
       {"no_data", "facets that were interpolated or closed: never counted as covered"},
       {"kind", "predicted visibility: computed from poses and surface, not from the images"}});
}

// A raster that names its datum must have that of the views.
void require_same_datum(const AuditedSurface& surface, const CoverageViews& views, const fs::path& path) {
  if (surface.height_datum.empty() || !views.origin) return;
  const std::string expected = io::height_type_text(views.origin->height_type, views.origin->geoid);
  if (surface.height_datum != expected)
    throw base::Error(base::ErrorCode::crs_mismatch, "surface and views measure heights from different datums")
        .file(path.string())
        .found(surface.height_datum)
        .allowed(expected)
        .hint("Import the views with heights of that datum: cairn import dji --takeoff-height, --takeoff-datum.");
}

// Views with the surface above them and none below.
std::size_t views_below(const visibility::Scene& scene, const coverage::ViewSet& set) {
  std::vector<geometry::Ray> down, up;
  for (const coverage::View& view : set.views) {
    down.push_back({view.T_world_camera.translation, -geometry::Vec3::UnitZ()});
    up.push_back({view.T_world_camera.translation, geometry::Vec3::UnitZ()});
  }
  const auto ground = scene.cast(down), roof = scene.cast(up);
  std::size_t count = 0;
  for (std::size_t i = 0; i < ground.size(); ++i) count += !ground[i].hit() && roof[i].hit() ? 1U : 0U;
  return count;
}

// What was judged: the facets of the surface, the large ones in pieces.
struct Judged {
  coverage::CutMesh cut;  // empty where nothing was cut
  std::vector<std::uint8_t> observed;
  std::vector<std::uint32_t> facet_cell;
  FacetCoverage metrics;
  Audit audit;

  [[nodiscard]] const geometry::TriangleMesh& mesh(const AuditedSurface& surface) const {
    return cut.parent.empty() ? surface.mesh : cut.mesh;
  }
};

template <typename T>
std::vector<T> of_parents(const std::vector<T>& values, const std::vector<std::uint32_t>& parent) {
  std::vector<T> result;
  if (values.empty()) return result;
  result.reserve(parent.size());
  for (const std::uint32_t p : parent) result.push_back(values[p]);
  return result;
}

// Cuts large facets where there are any.
Judged cut(const AuditedSurface& surface, double edge, base::RunContext& ctx) {
  Judged judged{{}, surface.observed, surface.facet_cell, {}, {}};
  if (edge <= 0.0) return judged;
  coverage::CutMesh pieces = coverage::cut_large_facets(surface.mesh, edge, kMostPieces);
  if (pieces.whole == surface.mesh.triangles.size()) return judged;
  if (pieces.edge_m > edge)
    ctx.warn("Large facets are cut to edges of " + base::to_fixed(pieces.edge_m, 1) + " m, not of " +
             base::to_text(edge) + " m: more would be too many");
  judged.observed = of_parents(surface.observed, pieces.parent);
  judged.facet_cell = of_parents(surface.facet_cell, pieces.parent);
  judged.cut = std::move(pieces);
  return judged;
}

// Share of each facet's area that passes.
std::vector<double> passed_share(const Judged& judged, std::size_t facets) {
  if (judged.cut.parent.empty()) return {};
  std::vector<double> area(facets, 0.0), passed(facets, 0.0);
  for (std::size_t i = 0; i < judged.cut.parent.size(); ++i) {
    const geometry::Triangle& t = judged.cut.mesh.triangles[i];
    const std::size_t count = judged.cut.mesh.vertices.size();
    if (t[0] >= count || t[1] >= count || t[2] >= count) continue;
    const double a = judged.cut.mesh.area_vector(i).norm();
    area[judged.cut.parent[i]] += a;
    if (judged.audit.verdicts[i] == coverage::Verdict::passed) passed[judged.cut.parent[i]] += a;
  }
  for (std::size_t f = 0; f < facets; ++f) passed[f] = area[f] > 0.0 ? passed[f] / area[f] : 0.0;
  return passed;
}

void write_facet_rows(const fs::path& path, const AuditedSurface& surface, const visibility::Scene& scene,
                      const Judged& judged, const coverage::ViewSet& views, const CoverageStageOptions& options,
                      base::RunContext& ctx) {
  if (judged.cut.parent.empty()) {
    write_facets(path, judged.metrics, judged.audit.verdicts, {});
    return;
  }
  // Facets that were cut have their own centroids too.
  const FacetCoverage metrics = coverage::coverage(surface.mesh, scene, views, options.visibility, ctx);
  const Audit audit = coverage::audit(surface.mesh, metrics, surface.observed, options.gates);
  write_facets(path, metrics, audit.verdicts, passed_share(judged, surface.mesh.triangles.size()));
}

// Empty where the views have no frame on the Earth.
std::optional<CoverageCells> cells_of(const AuditedSurface& surface, const visibility::Scene& scene,
                                      const Judged& judged, double cell, bool has_frame) {
  if (!has_frame) return std::nullopt;
  if (surface.grid) return cells_of_raster(*surface.grid, judged.facet_cell, judged.metrics, judged.audit);
  if (judged.cut.parent.empty()) return cells_of_mesh(surface.mesh, scene, judged.metrics, judged.audit, cell);
  const visibility::Scene pieces(judged.cut.mesh);
  return cells_of_mesh(judged.cut.mesh, pieces, judged.metrics, judged.audit, cell);
}

io::Json write_targets(const fs::path& out, const CoverageInputs& in, const CoverageViews& views,
                       const AuditedSurface& surface, const visibility::Scene& scene,
                       const CoverageStageOptions& options, std::vector<base::Reject>& rejects,
                       std::vector<coverage::TargetAudit>& rows, base::RunContext& ctx) {
  CoverageTargets targets = read_coverage_targets(in.targets, in.contacts, views.origin);
  coverage::TargetOptions own = options.targets;
  // A boulder in a terrain model is about a cell wider than it is.
  if (surface.grid) own.clearance_m = std::max(own.clearance_m, 1.5 * surface.grid->cell);
  const bool is_surface = surface.targets_themselves;
  coverage::TargetsAudit audit =
      coverage::audit_targets(is_surface ? geometry::TriangleMesh{} : surface.mesh, surface.observed, scene,
                              targets.bodies, views.set, options.visibility, options.gates, own, ctx);
  rejects.insert(rejects.end(), targets.rejects.begin(), targets.rejects.end());
  rejects.insert(rejects.end(), audit.rejects.begin(), audit.rejects.end());
  io::Json list = io::Json::array();
  std::size_t passed = 0;
  for (const auto& target : audit.targets) {
    list.push(to_json(target));
    passed += target.passed ? 1 : 0;
  }
  io::Json file = io::Json::object({{"schema_version", 1}});
  if (views.origin) file.set("frame", io::to_json(*views.origin));
  file.set("clearance_m", own.clearance_m);
  file.set("targets", std::move(list));
  base::write_file(out / "targets_coverage.json", file.dump() + "\n");
  write_target_rows(out / "targets_coverage.csv", audit.targets);
  rows = std::move(audit.targets);
  return io::Json::object({{"audited", rows.size()},
                           {"passed", passed},
                           {"left_out", targets.rejects.size() + targets.bodies.size() - rows.size()}});
}

io::Json frame_summary(const std::vector<FrameFigures>& frames, double max_blur_px) {
  std::vector<double> blur;
  for (const FrameFigures& f : frames)
    if (f.blur_px) blur.push_back(*f.blur_px);
  io::Json result = io::Json::object({{"known", blur.size()}, {"limit_px", max_blur_px}});
  if (blur.empty()) return result;
  std::sort(blur.begin(), blur.end());
  result.set("median_px", blur[(blur.size() - 1) / 2]);
  result.set("largest_px", blur.back());
  result.set("frames_above", std::count_if(blur.begin(), blur.end(), [&](double b) { return b > max_blur_px; }));
  return result;
}

}  // namespace

void CoverageStageOptions::visit(base::OptionVisitor& v) {
  visibility.visit(v);
  gates.visit(v);
  gaps.visit(v);
  bootstrap.visit(v);
  targets.visit(v);
  v.real("sample-edge-m", sample_edge_m, 0.0, 1e6, "facets with a longer edge are cut for the audit, m; 0 = never");
  v.flag("facets-csv", facets_csv, "write facets.csv, a row a facet");
  v.real("raster-cell-m", raster_cell_m, 0.01, 1000.0, "cell of views.tif where the surface is a mesh, m");
  v.real("eye-height-m", eye_height_m, 0.0, 1e5, "height above the surface of a viewshed's eye given without one, m");
  v.flag("page", page, "write audit.html");
  v.flag("layers", layers, "write coverage.gpkg: frames, footprints, gaps");
  v.choice("colour-mesh", colour_mesh, colour_metrics(), "metric that coverage.ply and coverage.glb are coloured by");
  v.real("max-blur-px", max_blur_px, 0.0, 1000.0, "frames that the flight blurs more are counted, px");
}

Outcome coverage_stage(const CoverageInputs& in, const fs::path& out, const CoverageStageOptions& options,
                       base::RunContext& ctx) {
  CoverageStageOptions checked = options;
  checked.visibility.metrics = true;
  base::validate(base::bind_options(checked), "coverage");
  CoverageViews views = read_coverage_views(in.views, in.format);
  std::optional<geodesy::LocalFrame> frame;
  if (views.origin) frame.emplace(views.origin->position);
  const AuditedSurface surface = read_audited_surface(in.surface, frame, ctx);
  require_same_datum(surface, views, in.surface);
  for (const auto& note : surface.notes) ctx.warn(in.surface.filename().string() + ": " + note);
  if (views.set.views.empty()) ctx.warn("There are no views: nothing is covered");
  ctx.check_memory(300 * static_cast<std::uint64_t>(surface.mesh.triangles.size()), "coverage");
  ctx.check_stop();

  // The counts are those of a plain Embree loop; see visibility::Tracing.
  const visibility::Scene scene(surface.mesh, visibility::Tracing::fast);
  const std::size_t below = views_below(scene, views.set);
  if (below > 0)
    ctx.warn(std::to_string(below) + " of " + std::to_string(views.set.views.size()) +
             " views stand below the surface: are heights of views and surface measured from the same datum?");
  Judged judged = cut(surface, options.sample_edge_m, ctx);
  const geometry::TriangleMesh& mesh = judged.mesh(surface);
  judged.metrics = coverage::coverage(mesh, scene, views.set, checked.visibility, ctx);
  judged.audit = coverage::audit(mesh, judged.metrics, judged.observed, options.gates);
  const auto gaps = coverage::find_gaps(mesh, judged.audit.verdicts, views.set, options.gaps);
  ctx.check_stop();

  CoverageFigures figures = coverage_figures(mesh, judged.metrics, judged.audit, options.gates);
  io::Json& summary = figures.summary;
  summary.set("facets", surface.mesh.triangles.size());
  summary.set("samples", mesh.triangles.size());
  if (const auto interval = coverage::completeness_interval(mesh, judged.audit, options.bootstrap, ctx)) {
    summary.set("completeness_interval_95", std::vector<double>{interval->low, interval->high});
    summary.set("interval", io::Json::object({{"method", "block bootstrap"},
                                              {"block_m", interval->block_m},
                                              {"blocks", interval->blocks},
                                              {"draws", options.bootstrap.replicates}}));
  }
  summary.set("frames", views.set.views.size());
  summary.set("frames_below_surface", below);
  summary.set("gaps", gaps.size());
  double gap_area = 0.0;
  for (const auto& gap : gaps) gap_area += gap.area_m2;
  summary.set("gap_area_m2", gap_area);
  const auto frames = frame_figures(views, in.views, scene, ctx);
  write_frame_rows(out / "frames_coverage.csv", frames);
  summary.set("blur", frame_summary(frames, options.max_blur_px));
  std::vector<coverage::TargetAudit> targets;
  if (!in.targets.empty())
    summary.set("targets", write_targets(out, in, views, surface, scene, checked, views.rejects, targets, ctx));
  if (!in.points.empty())
    summary.set("points",
                answer_points(out, parse_points(in.points, surface, scene, 0.0), scene, views, checked.visibility));
  if (!in.viewsheds.empty())
    summary.set("viewsheds", answer_viewsheds(out, parse_points(in.viewsheds, surface, scene, options.eye_height_m),
                                              surface, scene, options.visibility.end_gap, ctx));

  io::Json file = io::Json::object({{"schema_version", 1}});
  if (views.origin) file.set("frame", io::to_json(*views.origin));
  for (const auto& [name, value] : summary.as_object()) file.set(name, value);
  file.set("histograms", figures.histograms);
  file.set("definitions", definitions());
  file.set("validation",
           "Counts and angles of the ray casting equal an independent brute-force caster on test scenes in every facet "
           "away from silhouettes.");
  base::write_file(out / "coverage.json", file.dump() + "\n");
  if (options.facets_csv) write_facet_rows(out / "facets.csv", surface, scene, judged, views.set, checked, ctx);
  const std::optional<CoverageCells> cells = cells_of(surface, scene, judged, options.raster_cell_m, frame.has_value());
  if (frame) {
    io::write_gaps(out / "gaps.json", {*views.origin, gaps});
    cells->write(out / "views.tif", surface.grid ? surface.crs : frame->raster_crs_wkt());
    if (options.layers) write_coverage_layers(out / "coverage.gpkg", views, surface.mesh, gaps);
  }
  if (options.colour_mesh != "none") write_coloured_mesh(out, mesh, judged.metrics, judged.audit, options.colour_mesh);
  if (options.page)
    write_coverage_page(out / "audit.html", "Coverage audit of " + in.surface.filename().string(), summary,
                        figures.histograms, gaps, frames, targets, cells, options.max_blur_px, surface.notes);
  return {std::move(summary), std::move(views.rejects)};
}

std::unique_ptr<Stage> make_coverage_stage() {
  return make_function_stage<CoverageStageOptions>(
      {"coverage",
       {"terrain"},
       {"locate"},
       [](const StageInputs& in, const CoverageStageOptions&) {
         std::error_code ignored;
         const auto bytes = fs::file_size(in.products / "surface.tif", ignored);
         // Before the surface is there, one of a few million cells is assumed.
         constexpr std::uint64_t kAssumed = std::uint64_t{256} << 20U;
         return ignored ? Estimate{2 * kAssumed, kAssumed / 4} : Estimate{100 * bytes, 8 * bytes};
       },
       [](const StageInputs& in, const fs::path& out, const CoverageStageOptions& options, base::RunContext& ctx) {
         return coverage_stage(
             {in.products / "surface.tif", in.survey, "survey", product(in, "locate", "targets.json"), {}}, out,
             options, ctx);
       }});
}

}  // namespace cairn::pipeline
