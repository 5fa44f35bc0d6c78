// Verdict on each facet, and how much of the surface passes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "base/options.hpp"
#include "coverage/coverage.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::coverage {

// Why a facet fails: the first that applies, in this order.
enum class Verdict : std::uint8_t {
  passed,
  no_data,       // closed or interpolated, not observed: never covered, whatever looks at it
  out_of_frame,  // its centroid lies in fewer frames than views are asked for
  occluded,      // in enough frames that it faces, but something stands in the way
  too_oblique,   // in enough frames, but turned away, or seen too flat
  too_coarse,    // ground sampling distance above the limit
  low_parallax,  // all views from about one direction
};
inline constexpr std::size_t kVerdicts = 7;

// "passed", "no_data", "out_of_frame", ...
[[nodiscard]] std::string_view name_of(Verdict verdict);

// Defaults: three views as Skyline PhotoMesh asks for; 60 deg in two views; below 5 deg of parallax depth is not
// determined. The sampling distance is the user's to say.
struct GateOptions {
  std::int64_t min_views = 3;
  double max_incidence_deg = 60.0;  // must hold in two views (in one where min_views is 1)
  double max_gsd_mm = 0.0;          // 0 = not asked for
  double min_parallax_deg = 5.0;

  void visit(base::OptionVisitor& v) {
    v.integer("min-views", min_views, 1, 1000, "views a facet must be seen from");
    v.real("max-incidence-deg", max_incidence_deg, 0.0, 90.0, "largest angle to the normal, met by two views, deg");
    v.real("max-gsd-mm", max_gsd_mm, 0.0, 1e6, "largest ground sampling distance of the best view, mm; 0 = no limit");
    v.real("min-parallax-deg", min_parallax_deg, 0.0, 180.0, "least angle between the two widest views, deg");
  }
};

// The verdict on one observed facet. metrics must hold values, not counts only.
[[nodiscard]] Verdict judge(const FacetCoverage& metrics, std::size_t facet, const GateOptions& gates);

struct Audit {
  std::vector<Verdict> verdicts;  // one a facet
  // Surface area [m^2] by verdict; degenerate facets count nowhere.
  std::array<double, kVerdicts> area_m2{};
  std::array<std::size_t, kVerdicts> facets{};

  [[nodiscard]] double area(Verdict v) const { return area_m2[static_cast<std::size_t>(v)]; }
  [[nodiscard]] double observed_area() const;  // all but no_data
  // Area fraction of the observed facets that pass all gates; 0 where nothing was observed.
  [[nodiscard]] double completeness() const;
};

// observed: one flag a facet, or empty where all were. metrics must hold values, not counts only; else
// invalid_argument. Cost linear.
[[nodiscard]] Audit audit(const geometry::TriangleMesh& mesh, const FacetCoverage& metrics,
                          std::span<const std::uint8_t> observed, const GateOptions& gates);

}  // namespace cairn::coverage
