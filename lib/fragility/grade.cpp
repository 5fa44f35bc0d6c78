#include "fragility/grade.hpp"

#include <algorithm>
#include <string_view>

namespace cairn::fragility {
namespace {

using survey::Grade;

// Keeps the worst grade allowed so far and every reason that lowered it.
class Ceiling {
 public:
  void lower_to(Grade allowed, std::string_view reason) {
    grading_.reasons.emplace_back(reason);
    grading_.grade = std::max(grading_.grade, allowed);
  }
  [[nodiscard]] Grading result() const { return grading_; }

 private:
  Grading grading_{Grade::measured, {}};
};
static_assert(Grade::measured < Grade::bounded && Grade::bounded < Grade::screening &&
              Grade::screening < Grade::not_measurable);

}  // namespace

void GradeOptions::visit(base::OptionVisitor& visitor) {
  visitor.integer("grade-min-points", min_points, 4, 1'000'000, "rock points below which no alpha is printed");
  visitor.real("grade-min-resolution", min_resolution, 1.0, 1000.0,
               "lesser of width and height over point spacing below which no alpha is printed");
  visitor.real("grade-max-unseen-fraction", max_unseen_fraction, 0.0, 1.0,
               "unseen share of the closed surface above which no alpha is printed");
  visitor.real("grade-min-sides-seen", min_sides_seen, 0.0, 1.0,
               "share of azimuths with a seen flank below which no alpha is printed");
  visitor.real("grade-bounded-min-contact", bounded_min_contact, 0.0, 1.0,
               "observed share of the contact perimeter needed for grade bounded");
  visitor.real("grade-bounded-max-unseen", bounded_max_unseen, 0.0, 1.0,
               "largest unseen share of the surface for grade bounded");
  visitor.real("grade-measured-min-contact", measured_min_contact, 0.0, 1.0,
               "observed share of the contact perimeter needed for grade measured");
  visitor.real("grade-measured-max-unseen", measured_max_unseen, 0.0, 1.0,
               "largest unseen share of the surface for grade measured");
  visitor.real("grade-measured-min-resolution", measured_min_resolution, 1.0, 10000.0,
               "lesser of width and height over point spacing needed for grade measured");
}

Grading grade(const Evidence& evidence, const GradeOptions& options) {
  Ceiling ceiling;
  if (evidence.contact_assumed) ceiling.lower_to(Grade::screening, "contact_assumed");
  else if (evidence.contact_observed_share < options.bounded_min_contact)
    ceiling.lower_to(Grade::screening, "contact_partly_seen");
  else if (evidence.contact_observed_share < options.measured_min_contact)
    ceiling.lower_to(Grade::bounded, "contact_partly_seen");

  // What the flight cannot have seen was not seen, whatever the line says.
  if (evidence.contact_covered_share) {
    if (*evidence.contact_covered_share < options.bounded_min_contact)
      ceiling.lower_to(Grade::screening, "contact_not_covered");
    else if (*evidence.contact_covered_share < options.measured_min_contact)
      ceiling.lower_to(Grade::bounded, "contact_not_covered");
  }

  bool unknown = evidence.points == 0 || !(evidence.point_spacing_m > 0.0);
  if (evidence.points > 0 && evidence.points < static_cast<std::size_t>(options.min_points))
    ceiling.lower_to(Grade::not_measurable, "too_few_points");
  if (evidence.point_spacing_m > 0.0) {
    const double resolution = std::min(evidence.width_m, evidence.height_m) / evidence.point_spacing_m;
    if (resolution < options.min_resolution) ceiling.lower_to(Grade::not_measurable, "too_coarse");
    else if (resolution < options.measured_min_resolution) ceiling.lower_to(Grade::bounded, "too_coarse");
  }
  if (!evidence.sides_seen_share) unknown = true;
  else if (*evidence.sides_seen_share < options.min_sides_seen)
    ceiling.lower_to(Grade::not_measurable, "sides_not_seen");
  if (!evidence.unseen_area_fraction) unknown = true;
  else if (*evidence.unseen_area_fraction > options.max_unseen_fraction)
    ceiling.lower_to(Grade::not_measurable, "mostly_unseen");
  else if (*evidence.unseen_area_fraction > options.bounded_max_unseen)
    ceiling.lower_to(Grade::screening, "partly_unseen");
  else if (*evidence.unseen_area_fraction > options.measured_max_unseen)
    ceiling.lower_to(Grade::bounded, "partly_unseen");
  if (unknown) ceiling.lower_to(Grade::bounded, "surface_evidence_unknown");
  return ceiling.result();
}

}  // namespace cairn::fragility
