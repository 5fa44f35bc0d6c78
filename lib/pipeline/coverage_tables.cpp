#include "pipeline/coverage_tables.hpp"

#include <cmath>
#include <cstdint>

#include "io/csv.hpp"

namespace cairn::pipeline {
namespace {

// Four decimals: 0.1 um a pixel and 0.36" are finer than any of the figures are good for.
double rounded(double value) {
  constexpr double kSteps = 1e4;
  return std::round(value * kSteps) / kSteps;
}

}  // namespace

void write_facets(const std::filesystem::path& path, const coverage::FacetCoverage& m,
                  std::span<const coverage::Verdict> verdicts, std::span<const double> passed_share) {
  io::CsvWriter csv(path, {"facet", "views", "in_frame", "facing", "gsd_best_mm", "gsd_median_mm", "incidence_best_deg",
                           "incidence_second_deg", "parallax_deg", "verdict", "incidence_median_deg",
                           "parallax_second_deg", "azimuth_bins", "sigma_max_mm", "sigma_z_mm", "passed_share"});
  const auto real = [&csv](float value) { csv.cell(rounded(static_cast<double>(value))); };
  for (std::size_t i = 0; i < m.views.size(); ++i) {
    csv.cell(static_cast<std::uint64_t>(i))
        .cell(static_cast<std::uint64_t>(m.views[i]))
        .cell(static_cast<std::uint64_t>(m.in_frame[i]))
        .cell(static_cast<std::uint64_t>(m.facing[i]));
    for (const auto* column :
         {&m.gsd_best_mm, &m.gsd_median_mm, &m.incidence_best_deg, &m.incidence_second_deg, &m.parallax_deg})
      real((*column)[i]);
    csv.cell(coverage::name_of(verdicts[i]));
    real(m.incidence_median_deg[i]);
    real(m.parallax_second_deg[i]);
    csv.cell(coverage::azimuth_bins(m.azimuths[i]));
    real(m.sigma_max_mm[i]);
    real(m.sigma_z_mm[i]);
    const double share = verdicts[i] == coverage::Verdict::passed ? 1.0 : 0.0;
    csv.cell(passed_share.empty() ? share : rounded(passed_share[i])).end_row();
  }
  csv.finish();
}

}  // namespace cairn::pipeline
