// A polar plot of tipping, as SVG text.
#pragma once

#include <string>
#include <string_view>

#include "survey/rock.hpp"

namespace cairn::fragility {

// Quasi-static tipping acceleration [g] by direction of toppling, north up, clockwise; the critical direction
// marked; grade and reasons in the title. Self-contained, no script, the same bytes on every run.
// Precondition: tipping.a_qs_g_by_azimuth has 360 finite values (throws failed_precondition otherwise: a rock that is
// not_measurable has no plot).
[[nodiscard]] std::string polar_plot_svg(const survey::Tipping& tipping, std::string_view title);

}  // namespace cairn::fragility
