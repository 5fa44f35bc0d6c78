// `cairn fragility --shake` and `--pulse-tests`: rocks under records, and under one-cosine pulses.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fragility/assessment.hpp"
#include "fragility/plane_contact.hpp"
#include "fragility/shake_suite.hpp"
#include "io/accelerogram.hpp"
#include "pipeline/outcome.hpp"

namespace cairn::pipeline {

struct ShakeFiles {
  std::filesystem::path input;                 // a mesh, or a folder that `surface` wrote
  std::filesystem::path contact;               // contact.csv; "" = as the input has it, else a band at the base
  std::vector<std::filesystem::path> records;  // of ground motion
  std::vector<std::filesystem::path> models;   // published models (JSON)
};

struct ShakeOptions {
  // "edges": the support polygon's edges. "plane": the body on a rigid plane, rolling over its hull, without a contact.
  std::string contact_model = "edges";
  std::int64_t bootstrap_draws = 300;
  fragility::SuiteOptions suite;
  fragility::MapOptions map;
  io::RecordOptions record;

  void visit(base::OptionVisitor& visitor);
};

// "0.1:2:0.1" (first:last:step), or a list "0.5,1,2". Throws invalid_argument: nothing, not ascending, not above 0,
// more than 10000.
[[nodiscard]] std::vector<double> parse_scales(std::string_view text);

// Per rock <stem>_shake.json, <stem>_outcomes.csv (every run), <stem>_curve.csv (P on a grid with its band),
// <stem>_fragility.svg, and where map-*-steps are not 0 <stem>_overturning.{csv,svg}.
// Summary: records (measures computed here), rocks (counts, logistic, by_eta, grade). A record that moves nothing, a
// vertical one without its horizontal one, a rock that does not stand are rejects.
[[nodiscard]] Outcome shake_files(const ShakeFiles& in, const std::filesystem::path& out,
                                  const std::vector<double>& scales, const ShakeOptions& options,
                                  const fragility::FragilityOptions& assessment, base::RunContext& ctx);

// tests: CSV with pga_g and pgv_over_pga_s, and where known a column whose name ends with "overturned" (0 or 1).
// Writes predictions.csv (the tests' columns, probability, predicted). Summary: contact taken, azimuth, angles; with
// outcomes accuracy and Brier score, beside a logistic in ln PGV fitted to them in ten folds.
[[nodiscard]] Outcome pulse_test_files(const std::filesystem::path& mesh, const std::filesystem::path& tests,
                                       const std::filesystem::path& out, const fragility::PulseTestOptions& options,
                                       base::RunContext& ctx);

}  // namespace cairn::pipeline
