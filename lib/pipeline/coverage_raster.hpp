// views.tif: the metrics of a coverage audit on a grid.
#pragma once

#include <filesystem>
#include <string>

#include "coverage/audit.hpp"
#include "coverage/coverage.hpp"
#include "geometry/grid.hpp"
#include "pipeline/audited_surface.hpp"
#include "visibility/scene.hpp"

namespace cairn::pipeline {

// The worst of the facets of one cell; NaN where nothing was observed.
struct CoverageCells {
  geometry::Grid<float> views, gsd, incidence, parallax, parallax_second, azimuth_bins, sigma, overlap;

  explicit CoverageCells(const geometry::GridGeometry& geometry);
  void take(std::size_t cell, std::size_t facet, const coverage::FacetCoverage& metrics);
  void write(const std::filesystem::path& path, const std::string& crs) const;
};

// On the grid of a raster surface. facet_cell: of each facet judged.
[[nodiscard]] CoverageCells cells_of_raster(const geometry::GridGeometry& grid,
                                            std::span<const std::uint32_t> facet_cell,
                                            const coverage::FacetCoverage& metrics, const coverage::Audit& audit);

// Of the facet seen from straight above, in cells of `cell` [m]; larger ones where more than 1e8 would be needed.
[[nodiscard]] CoverageCells cells_of_mesh(const geometry::TriangleMesh& mesh, const visibility::Scene& scene,
                                          const coverage::FacetCoverage& metrics, const coverage::Audit& audit,
                                          double cell);

}  // namespace cairn::pipeline
