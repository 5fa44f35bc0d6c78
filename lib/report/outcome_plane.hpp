// Outcomes in the plane of PGA and PGV/PGA, as SVG.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cairn::report {

struct PlaneMark {
  double pga_g = 0.0, pgv_over_pga_s = 0.0;  // > 0
  bool toppled = false;
  std::optional<bool> toppled_plane;  // what the plane model says, where it was asked
};

// Logarithmic axes. Full mark: toppled; open mark: stood; a cross over it where the plane model says otherwise. A
// dashed line at the quasi-static tipping acceleration. Self-contained, no script, the same bytes on every run.
[[nodiscard]] std::string outcome_plane_svg(std::span<const PlaneMark> marks, double a_qs_g, std::string_view title);

}  // namespace cairn::report
