// A published map and its scenario of path queries: are the routes as short as they can be?
#pragma once

#include <filesystem>

#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

// Answers every query of a Moving AI scenario over its map (plain shortest paths) and compares with the published
// lengths. Summary: queries, found, largest_relative_difference and the query it belongs to, mean_relative_difference,
// different (queries that differ by more than 1e-5), total_length_m (in cells of 1 m), expansions. Rejects: queries
// without a path (start_blocked, goal_blocked, no_path). Starts on water ('W') walk on water only, all others on '.',
// 'G' and 'S'. Where `csv` is not empty, one row a query is written there.
Outcome scenario_stage(const std::filesystem::path& map, const std::filesystem::path& scenario,
                       const std::filesystem::path& csv, base::RunContext& ctx);

}  // namespace cairn::pipeline
