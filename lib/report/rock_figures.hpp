// Figures of one rock as SVG: sections, side views, what dominates the uncertainty, a photograph with the contact line.
// All are self-contained (pictures embedded), without script, and the same bytes on every run.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "geometry/vec.hpp"
#include "survey/rock.hpp"

namespace cairn::report {

// The two points where a vertical plane through the centre of mass leaves the support polygon (fragility.md 1.1).
// s: level distance from the plumb line along the plane's azimuth, m; alpha = atan2(s, height of the centre above it).
struct RockingPoint {
  double s_m = 0.0, z_m = 0.0, alpha_rad = 0.0, r_m = 0.0;
};
struct RockingPair {
  RockingPoint towards, against;  // of the azimuth
};
// support: ring, counter-clockwise from above. Empty (false) where the plane does not cross it twice on both sides.
[[nodiscard]] bool rocking_pair(const std::vector<geometry::Vec3>& support, const geometry::Vec3& centre,
                                double azimuth_deg, RockingPair& pair);

// Closed outlines of the section of a closed mesh by the vertical plane through `through` with that azimuth: (s, z).
[[nodiscard]] std::vector<std::vector<geometry::Vec2>> vertical_section(const geometry::TriangleMesh& mesh,
                                                                        const geometry::Vec3& through,
                                                                        double azimuth_deg);

// Two sections through the centre of mass, along the critical azimuth and across it, to one scale: outline, centre,
// plumb line, rocking points with alpha and R of the section. Precondition: mass and tipping.critical.
[[nodiscard]] std::string sections_svg(const survey::Rock& rock, const geometry::TriangleMesh& mesh,
                                       std::string_view title);

// Four views from the side, the first with the critical direction to the right: shaded mesh, centre of mass, plumb
// line, the contact's outermost points as seen and their angles. Precondition as above.
[[nodiscard]] std::string side_views_svg(const survey::Rock& rock, const geometry::TriangleMesh& mesh,
                                         std::string_view title, std::size_t view_px = 260);

// Shares of the variance of alpha as bars with the inputs they were drawn from, and the quantiles. "" where the rock
// has no Monte Carlo record.
[[nodiscard]] std::string uncertainty_svg(const survey::Rock& rock, std::string_view title);

// A line over a photograph's part, in its pixels.
struct PhotoLine {
  std::vector<geometry::Vec2> points;
  bool visible = true;   // not hidden by the rock itself; else drawn thin
  bool observed = true;  // seen in the cloud; else dashed
};
// jpeg: file content of width x height pixels.
[[nodiscard]] std::string photo_svg(std::string_view jpeg, double width_px, double height_px,
                                    const std::vector<PhotoLine>& lines, std::string_view title);

}  // namespace cairn::report
