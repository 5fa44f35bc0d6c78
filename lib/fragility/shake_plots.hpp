// Figures of shaking, as SVG text: self-contained, the same bytes on every run.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "fragility/logistic.hpp"
#include "fragility/shake_suite.hpp"

namespace cairn::fragility {

// Probability of overturning against PGA at one PGV/PGA: the fit, its 5-95 and 16-84 % bands (left out where `banded`
// is false), and the outcomes as the share that toppled in steps of PGA. `subtitle` says grade and counts.
[[nodiscard]] std::string fragility_curve_svg(std::span<const CurvePoint> curve, bool banded,
                                              std::span<const ShakeOutcome> outcomes, std::string_view title,
                                              std::string_view subtitle);

// Share that one-cosine pulses overturn over PGA and PGV/PGA, logarithmic axes; where a fit is given, its median line.
[[nodiscard]] std::string overturning_map_svg(const OverturningMap& map, const LogisticFit* fit, std::string_view title,
                                              std::string_view subtitle);

}  // namespace cairn::fragility
