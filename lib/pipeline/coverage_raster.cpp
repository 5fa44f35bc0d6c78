#include "pipeline/coverage_raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "io/raster.hpp"

namespace cairn::pipeline {
namespace {

using coverage::Audit;
using coverage::FacetCoverage;
using geometry::Grid;
using geometry::Vec3;

constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
constexpr double kMostCells = 1e8;

void keep_least(float& kept, float value) {
  kept = std::isnan(kept) ? value : std::min(kept, value);
}
void keep_largest(float& kept, float value) {
  if (!std::isnan(value)) kept = std::isnan(kept) ? value : std::max(kept, value);
}

}  // namespace

CoverageCells::CoverageCells(const geometry::GridGeometry& g)
    : views(g, kNone),
      gsd(g, kNone),
      incidence(g, kNone),
      parallax(g, kNone),
      parallax_second(g, kNone),
      azimuth_bins(g, kNone),
      sigma(g, kNone),
      overlap(g, kNone) {}

void CoverageCells::take(std::size_t cell, std::size_t facet, const FacetCoverage& m) {
  keep_least(views.values[cell], static_cast<float>(m.views[facet]));
  keep_least(overlap.values[cell], static_cast<float>(m.in_frame[facet]));
  keep_least(azimuth_bins.values[cell], static_cast<float>(coverage::azimuth_bins(m.azimuths[facet])));
  if (m.views[facet] > 0) {
    keep_largest(gsd.values[cell], m.gsd_best_mm[facet]);
    keep_largest(incidence.values[cell], m.incidence_best_deg[facet]);
    keep_largest(sigma.values[cell], m.sigma_max_mm[facet]);
  }
  // One view has no parallax, two have no second one.
  keep_least(parallax.values[cell], m.views[facet] > 1 ? m.parallax_deg[facet] : 0.0F);
  keep_least(parallax_second.values[cell], m.views[facet] > 2 ? m.parallax_second_deg[facet] : 0.0F);
}

void CoverageCells::write(const std::filesystem::path& path, const std::string& crs) const {
  io::write_cog(
      path,
      {{"views", "", "frames that see the facet (predicted visibility)", views, std::nullopt},
       {"gsd_mm", "mm", "best ground sampling distance", gsd, std::nullopt},
       {"incidence_deg", "deg", "least angle between sight line and normal", incidence, std::nullopt},
       {"parallax_deg", "deg", "largest angle between two sight lines", parallax, std::nullopt},
       {"parallax_second_deg", "deg", "second largest angle between two sight lines", parallax_second, std::nullopt},
       {"azimuth_bins", "", "30-degree bins of azimuth with a view, 0 to 12", azimuth_bins, std::nullopt},
       {"sigma_mm", "mm", "predicted standard deviation along the direction known worst", sigma, std::nullopt},
       {"overlap", "", "frames that have the place inside, whatever stands between (2.5-D overlap)", overlap,
        std::nullopt}},
      crs);
}

CoverageCells cells_of_raster(const geometry::GridGeometry& grid, std::span<const std::uint32_t> facet_cell,
                              const FacetCoverage& metrics, const Audit& audit) {
  CoverageCells cells(grid);
  for (std::size_t f = 0; f < facet_cell.size(); ++f)
    if (audit.verdicts[f] != coverage::Verdict::no_data) cells.take(facet_cell[f], f, metrics);
  return cells;
}

CoverageCells cells_of_mesh(const geometry::TriangleMesh& mesh, const visibility::Scene& scene,
                            const FacetCoverage& metrics, const Audit& audit, double cell) {
  geometry::Box3 box;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (audit.verdicts[i] == coverage::Verdict::no_data) continue;
    const Vec3 c = mesh.centroid(i);
    if (c.allFinite()) box.extend(c);
  }
  if (box.empty()) return CoverageCells({0.0, cell, cell, 1, 1});
  const Vec3 size = box.size();
  const double edge = std::max(cell, std::sqrt(size.x() * size.y() / kMostCells));
  CoverageCells cells(geometry::covering_grid(box.min.head<2>(), box.max.head<2>(), edge));
  const geometry::GridGeometry& g = cells.views.geometry;
  std::vector<geometry::Ray> rays(g.columns);
  for (std::size_t r = 0; r < g.rows; ++r) {
    for (std::size_t c = 0; c < g.columns; ++c) {
      const geometry::Vec2 p = g.centre(r, c);
      rays[c] = {Vec3(p.x(), p.y(), box.max.z() + 1.0 + size.z()), -Vec3::UnitZ()};
    }
    const auto hits = scene.cast(rays);
    for (std::size_t c = 0; c < g.columns; ++c)
      if (hits[c].hit() && audit.verdicts[hits[c].triangle] != coverage::Verdict::no_data)
        cells.take(r * g.columns + c, hits[c].triangle, metrics);
  }
  return cells;
}

}  // namespace cairn::pipeline
