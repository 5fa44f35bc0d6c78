// The band about the line where a rock rests: who saw it, round the rock.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/options.hpp"
#include "base/run_context.hpp"
#include "coverage/audit.hpp"
#include "coverage/coverage.hpp"
#include "coverage/cylinder_mesh.hpp"
#include "survey/contact.hpp"

namespace cairn::coverage {

struct BasalOptions {
  double band_m = 0.1;           // each side of a contact line that is known
  double band_of_height = 0.15;  // lowest part of the wall that stands for it where it is not
  double max_gsd_mm = 5.0;       // best sampling distance in the band

  void visit(base::OptionVisitor& v) {
    v.real("basal-band-m", band_m, 1e-3, 10.0, "width of the basal band each side of the contact line, m");
    v.real("basal-band-of-height", band_of_height, 0.01, 1.0,
           "lowest part of a target that counts as its basal band where the contact is not known");
    v.real("basal-gsd-mm", max_gsd_mm, 0.0, 1e6,
           "largest ground sampling distance in the basal band, mm; 0 = no limit");
  }
};

struct BasalAudit {
  bool contact_known = false;
  double perimeter_m = 0.0;
  double seen_share = 0.0;     // of the perimeter, with at least half the band's area passing
  double no_data_share = 0.0;  // of the perimeter, without an observed surface in the band
  double gsd_best_mm = 0.0;    // median over the band's area of the best sampling distance; NaN where none was seen
  // Share of the perimeter in each sector of azimuth about the target that was seen; NaN where none of it lies there.
  std::array<double, kSectors> seen_by_azimuth{};
};

// A contact that is known: the facets of the surface within band_m of the line, cut to a quarter of that, each judged
// by `gates` with the band's sampling distance. The line is cut into `kSectors` pieces of equal length; a facet belongs
// to the nearest. Empty where the surface has no facet near the line.
[[nodiscard]] std::optional<BasalAudit> audit_contact(const geometry::TriangleMesh& surface,
                                                      std::span<const std::uint8_t> observed,
                                                      const visibility::Scene& scene, const survey::Contact& contact,
                                                      const geometry::Vec2& axis, const ViewSet& views,
                                                      const CoverageOptions& visibility, const GateOptions& gates,
                                                      const BasalOptions& options, base::RunContext& ctx);

// One that is not: the wall's rows from the foot of each sector up. metrics: of the cylinder's facets, from `first` on;
// foot: height above the cylinder's bottom where the wall comes out of the ground, by sector [m].
[[nodiscard]] BasalAudit audit_lowest_part(const geometry::VerticalCylinder& cylinder, const FacetCoverage& metrics,
                                           std::size_t first, const std::array<double, kSectors>& foot,
                                           const GateOptions& gates, const BasalOptions& options);

}  // namespace cairn::coverage
