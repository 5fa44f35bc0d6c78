// How far a tipping angle can be trusted, from what was seen of the rock and of its contact.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "survey/rock.hpp"

namespace cairn::fragility {

// What is known about the evidence behind one mesh and its contact.
struct Evidence {
  std::size_t points = 0;        // rock points behind the mesh; 0 = not known (a mesh from a file)
  double point_spacing_m = 0.0;  // median distance to the nearest neighbour; 0 = not known
  double width_m = 0.0;          // lesser side of the rock in plan
  double height_m = 0.0;         // above the ground
  // Of the closed surface, 0..1: facets that no point supports (skirt, cap). Empty = not known.
  std::optional<double> unseen_area_fraction;
  // Of 36 azimuth sectors, 0..1: those with a rock point below half of the height. Empty = not known.
  std::optional<double> sides_seen_share;
  bool contact_assumed = true;          // a band at the base, not a digitised or segmented line
  double contact_observed_share = 0.0;  // of the contact perimeter, 0..1
  // Of the contact perimeter, 0..1: outside the gaps that a coverage audit found. Empty = no audit.
  std::optional<double> contact_covered_share;
};

// Thresholds of the grades. First values, chosen on the sampling argument in docs/science/tipping.md,
// not calibrated on tests.
struct GradeOptions {
  std::int64_t min_points = 50;           // fewer rock points: not_measurable
  double min_resolution = 6.0;            // lesser of width and height / point spacing below this: not_measurable
  double max_unseen_fraction = 0.6;       // unseen share of the closed surface above this: not_measurable
  double min_sides_seen = 0.5;            // share of azimuths with a seen flank below this: not_measurable
  double bounded_min_contact = 0.5;       // observed share of the contact perimeter for `bounded`
  double bounded_max_unseen = 0.35;       // unseen share of the surface for `bounded`
  double measured_min_contact = 0.9;      // observed share of the contact perimeter for `measured`
  double measured_max_unseen = 0.15;      // unseen share of the surface for `measured`
  double measured_min_resolution = 30.0;  // lesser of width and height / spacing for `measured`

  void visit(base::OptionVisitor& visitor);
};

struct Grading {
  survey::Grade grade = survey::Grade::not_measurable;
  // Why it is not better, reason codes: contact_assumed, contact_partly_seen, contact_not_covered, too_few_points,
  // too_coarse, sides_not_seen, mostly_unseen, partly_unseen, surface_evidence_unknown.
  std::vector<std::string> reasons;
};

// The worst grade that any single piece of evidence allows; unknown evidence allows at most `bounded`,
// an assumed contact at most `screening`.
[[nodiscard]] Grading grade(const Evidence& evidence, const GradeOptions& options);

}  // namespace cairn::fragility
