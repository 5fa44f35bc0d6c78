// facets.csv: what was found of each facet of the surface given.
#pragma once

#include <filesystem>
#include <span>

#include "coverage/audit.hpp"
#include "coverage/coverage.hpp"

namespace cairn::pipeline {

// metrics: of each facet's centroid. passed_share: of each facet's area, by its pieces; empty where none was cut: then
// 1 or 0 by the verdict.
void write_facets(const std::filesystem::path& path, const coverage::FacetCoverage& metrics,
                  std::span<const coverage::Verdict> verdicts, std::span<const double> passed_share);

}  // namespace cairn::pipeline
