// Charts as static SVG: they need no script, print sharply and scale.
#pragma once

#include <span>
#include <vector>

#include "report/html_text.hpp"
#include "report/report_data.hpp"

namespace cairn::report {

// Polar diagram of a_qs [g] toward each azimuth; north up, clockwise. values: 360, toppling toward 0, 1, .. 359 deg;
// values that are not finite or above 8 times the least are drawn at the rim. critical_deg: marked by an arrow.
[[nodiscard]] Html polar_chart(std::span<const double> values, double critical_deg);

// Bars of area share by a metric's bins, with the gate as a line and the failing bins in another tone.
[[nodiscard]] Html histogram_chart(const Histogram& histogram);

// A small line of values, for histories.
[[nodiscard]] Html spark_line(std::span<const double> values, std::string_view label);

// The next of 1, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten at or above value > 0.
[[nodiscard]] double nice_ceiling(double value);

}  // namespace cairn::report
