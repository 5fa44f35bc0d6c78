// A report with every section, for tests and for work on the page: the real objects and poses of Brighton Beach
// with synthetic ground, rocks of every grade, coverage and route around them.
#pragma once

#include <filesystem>

#include "report/report_data.hpp"

namespace cairn::testing {

// folder: tests/data/report. The same data on every call.
[[nodiscard]] report::ReportData sample_report(const std::filesystem::path& folder);

// The smallest report that has a table: one target, nothing else.
[[nodiscard]] report::ReportData tiny_report();

// Every text of the data tries to become markup or script.
[[nodiscard]] report::ReportData hostile_report();

// A rock of the given grade with mesh, contact and polar table, standing at `foot`.
[[nodiscard]] report::RockView sample_rock(std::int64_t id, const geometry::Vec3& foot, double width, double height,
                                           survey::Grade grade);

}  // namespace cairn::testing
