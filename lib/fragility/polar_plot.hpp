// A polar plot of tipping, as SVG text.
#pragma once

#include <string>
#include <string_view>

#include "survey/rock.hpp"

namespace cairn::fragility {

// Quasi-static tipping acceleration [g] by direction of toppling, north up, clockwise: the values on the rim as a line;
// the band between the bounds of the contact (inner, outer), where both are known; the 5-95 % band and the rose of
// critical directions where there are draws; the critical direction and its interval in words. Self-contained, no
// script, the same bytes on every run. north: what north means, "true north" in a local ENU frame. Precondition:
// tipping.a_qs_g_by_azimuth has 360 finite values (throws failed_precondition otherwise: a rock that is not_measurable
// has no plot).
[[nodiscard]] std::string polar_plot_svg(const survey::Tipping& tipping, std::string_view title,
                                         std::string_view north = "true north");

}  // namespace cairn::fragility
