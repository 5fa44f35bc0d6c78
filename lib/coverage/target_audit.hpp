// What the flight saw of each target: the walls and the top of its bounding cylinder, and the band where it rests.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "coverage/audit.hpp"
#include "coverage/basal_band.hpp"
#include "coverage/coverage.hpp"
#include "coverage/cylinder_mesh.hpp"
#include "survey/contact.hpp"
#include "survey/ids.hpp"

namespace cairn::coverage {

struct TargetOptions {
  double min_completeness = 0.9;      // of the wall, and of the top
  double max_gsd_of_height = 0.01;    // best sampling distance of wall and top, as a fraction of the height
  double min_perimeter = 0.9;         // of the basal band, seen well enough
  double max_sigma_of_width = 0.02;   // 95th percentile over wall and top of the predicted sigma
  std::int64_t min_azimuth_bins = 8;  // of twelve, about the target
  double clearance_m = 0.05;          // about a cylinder the surface is taken as part of the target
  BasalOptions basal;

  void visit(base::OptionVisitor& v) {
    v.real("target-completeness", min_completeness, 0.0, 1.0,
           "share of a target's wall, and of its top, that must pass");
    v.real("target-gsd-of-height", max_gsd_of_height, 0.0, 1.0,
           "largest ground sampling distance of wall and top as a fraction of the target's height; 0 = no limit");
    v.real("target-perimeter", min_perimeter, 0.0, 1.0, "share of the basal perimeter that must be seen");
    v.real("target-sigma-of-width", max_sigma_of_width, 0.0, 10.0,
           "largest predicted sigma (95th percentile) as a fraction of the target's width; 0 = no limit");
    v.integer("target-azimuth-bins", min_azimuth_bins, 0, 12, "30-degree bins of azimuth with a view of the target");
    v.real("target-clearance-m", clearance_m, 0.0, 100.0,
           "surface this near to a target's cylinder is taken as a part of it, m");
    basal.visit(v);
  }
};

struct TargetBody {
  survey::TargetId id;
  geometry::VerticalCylinder cylinder;  // local ENU, m
  survey::Contact contact;              // local ENU, m; empty = not known
};

// The facets of one part; what lies below the ground beside the target is left out.
struct PartAudit {
  double area_m2 = 0.0, buried_m2 = 0.0;
  std::array<double, kVerdicts> area_by_verdict{};
  double views_median = 0.0, gsd_median_mm = 0.0, incidence_median_deg = 0.0;  // by area; NaN where nothing has one

  [[nodiscard]] double completeness() const {
    return area_m2 > 0.0 ? area_by_verdict[static_cast<std::size_t>(Verdict::passed)] / area_m2 : 0.0;
  }
};

struct TargetAudit {
  survey::TargetId id;
  geometry::VerticalCylinder cylinder;
  PartAudit wall, top;
  std::array<double, kSectors> wall_by_azimuth{};  // completeness of each sector of the wall; NaN where it is buried
  BasalAudit basal;
  int azimuth_bins = 0;
  double sigma_95_mm = 0.0;  // of wall and top; NaN where a twentieth or more has none
  bool passed = false;
  std::vector<std::string> reasons;  // wall, top, basal_band, azimuths, sigma
};

struct TargetsAudit {
  std::vector<TargetAudit> targets;   // in the order given, those rejected left out
  std::vector<base::Reject> rejects;  // cylinder_not_finite, cylinder_without_height, cylinder_without_radius
  // The cylinders' facets, kCylinderFacets a target, with what was found.
  geometry::TriangleMesh mesh;
  std::vector<Verdict> verdicts;
  FacetCoverage metrics;
};

// What may stand in the way of looking at targets: the surface without what lies within `clearance` of a cylinder and
// above the lowest 15 % of its height, and `cylinders`, the mesh of all of them.
[[nodiscard]] geometry::TriangleMesh target_occluders(const geometry::TriangleMesh& surface,
                                                      const std::vector<TargetBody>& bodies,
                                                      const geometry::TriangleMesh& cylinders, double clearance);

// What may stand in the way: the surface without what lies within `clearance` of a target and above its foot (there the
// surface is the target itself, as coarse as its cells), and the cylinders in its place. Below the ground (the surface
// beside the wall, where that is lower than half the target's height) facets are buried and left out.
// A basal band with a known contact is looked at on the surface as it stands; see basal_band.hpp.
// gates: as for the surface, but for the sampling distance, which the target's height decides.
// surface may be empty. observed: one flag a facet of it, or empty.
// Cost: as coverage() of 3 700 facets a target, and one more scene of the surface.
[[nodiscard]] TargetsAudit audit_targets(const geometry::TriangleMesh& surface, std::span<const std::uint8_t> observed,
                                         const visibility::Scene& scene, const std::vector<TargetBody>& bodies,
                                         const ViewSet& views, const CoverageOptions& visibility,
                                         const GateOptions& gates, const TargetOptions& options, base::RunContext& ctx);

}  // namespace cairn::coverage
