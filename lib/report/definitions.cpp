#include "report/definitions.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace cairn::report {
namespace {

using Pair = std::pair<std::string_view, std::string_view>;

constexpr std::array kReasons{
    // Grades of rocks.
    Pair{"contact_assumed", "The contact with the ground was not seen; it was taken as a band at the base."},
    Pair{"contact_partly_seen", "Only a part of the contact's perimeter was seen."},
    Pair{"too_few_points", "Too few points fall on the object."},
    Pair{"cloud_missing", "The cloud does not reach this place."},
    Pair{"not_above_ground", "No point stands clear of the ground and its noise."},
    Pair{"too_few_ground_points", "Too few ground points lie around it."},
    Pair{"flat_points", "The points enclose no volume."},
    Pair{"surface_not_closed", "The surface could not be closed, so it has no volume."},
    Pair{"self_intersecting", "The closed surface passes through itself, so it has no volume."},
    Pair{"several_pieces", "The closed surface is in several pieces, so it has no volume."},
    Pair{"too_coarse", "The points are too far apart for a body of this size."},
    Pair{"sides_not_seen", "The flanks were not seen from enough directions."},
    Pair{"mostly_unseen", "Most of the closed surface was filled in, not seen."},
    Pair{"partly_unseen", "A part of the closed surface was filled in, not seen."},
    Pair{"surface_evidence_unknown", "It is not known which part of the surface was seen."},
    Pair{"slides_first", "On a rock-on-rock friction of the value in the options it would slide before it tips."},
    Pair{"no_contact", "No contact with the ground was found."},
    Pair{"point_contact", "The contact is a point: the body may roll, and a tipping angle does not describe it."},
    Pair{"line_contact", "The contact is a line: no support polygon can be drawn."},
    Pair{"plumb_point_outside",
         "The centre of mass does not lie above the contact: a contact is missing, the vertical is wrong, or the rock "
         "is wedged."},
    Pair{"not_in_equilibrium",
         "The centre of mass does not lie above the contact: a contact is missing, the vertical is wrong, or the rock "
         "is wedged."},
    Pair{"rolls_back", "On its single point of contact it is stable against rolling."},
    Pair{"rolls_away", "On its single point of contact it is not stable against rolling: something else holds it."},
    Pair{"equilibrium_uncertain", "Within the uncertainty of contact and mass the rock may not stand at all."},
    Pair{"contact_not_covered", "The flight cannot have seen all of the contact with the ground."},
    Pair{"no_contact_seen", "Nothing of the contact was seen: there is no lower bound."},
    Pair{"contact_above_centre", "A contact lies above the centre of mass: the rock is held from the side."},
    Pair{"mesh_not_closed", "The surface could not be closed, so it has no volume."},
    Pair{"no_ground", "No ground was found around the object."},
    Pair{"too_low", "The object does not rise above the ground by enough."},
    Pair{"no_points", "The cloud has no points here."},
    Pair{"outside_cloud", "The cloud does not reach this place."},
    Pair{"not_a_rock_class", "Objects of this class are not cut from the cloud."},
    // Targets.
    Pair{"too_few_detections", "Seen in too few images to be located."},
    Pair{"too_few_keyframes", "Seen from too few keyframes to be located."},
    Pair{"diverged", "The estimate did not settle."},
    Pair{"low_parallax", "The rays that see it are nearly parallel, so its distance is uncertain."},
    Pair{"seen_once", "Seen in one image only."},
    Pair{"too_few_boxes", "Fewer boxes agree on its place than are needed."},
    Pair{"one_direction", "Seen from one direction only, so its distance is unknown."},
    Pair{"uncertain_centre", "The standard deviation of its centre is too large."},
    Pair{"rarely_seen", "Most images that should show it do not: its boxes met by chance."},
    Pair{"inconsistent_boxes", "Its boxes do not meet in one point."},
    Pair{"covariance_is_spread", "Its covariance is the spread of the filter's points, not the centre's own."},
    Pair{"missed", "Not seen again for too many images."},
    Pair{"all_weights_zero", "A box held none of the filter's points, which stayed as they were."},
    Pair{"singular_covariance", "The filter's points fell on one another."},
    Pair{"points_behind_camera", "Points behind the camera were counted, as the published method does."},
    Pair{"not_converged", "The estimate was still changing when the images ended."},
};

constexpr std::array kCoverageReasons{
    Pair{"passed", "Passes every gate."},
    Pair{"no_data", "Interpolated or closed, not observed: never counted as covered."},
    Pair{"out_of_frame", "Lies in too few images."},
    Pair{"occluded", "In enough images, but something stands in the way."},
    Pair{"too_oblique", "In enough images, but turned away from them or seen too flat."},
    Pair{"oblique", "Seen at grazing angles only."},
    Pair{"too_coarse", "Seen from too far: the ground sampling distance is over its limit."},
    Pair{"coarse_gsd", "Seen from too far: the ground sampling distance is over its limit."},
    Pair{"low_parallax", "All lines of sight come from about one direction, so that depth is uncertain."},
    Pair{"few_views", "Seen in too few images."},
    Pair{"too_few_views", "Seen in too few images."},
    Pair{"no_view", "Seen in no image."},
};

constexpr std::array kTerms{
    Term{"α", "tipping angle", "°",
         "Rotation about an edge of the support polygon that brings the centre of mass above that edge. The least over "
         "all edges is printed. Slender rocks have small angles. Small angle = easily toppled."},
    Term{"toppling toward", "critical azimuth", "° from true north, clockwise",
         "Horizontal outward normal of the edge with the least angle. The ground would have to accelerate the other "
         "way."},
    Term{"a_qs", "quasi-static tipping acceleration", "g",
         "Steady horizontal acceleration, in units of 9.80665 m/s², that starts rocking toward an azimuth; tan α about "
         "a "
         "level edge. A screening number: shaking of that peak acceleration may or may not topple the rock."},
    Term{"v_min", "least toppling velocity", "m/s",
         "Least sudden change of ground velocity that overturns the rock about the critical edge."},
    Term{"R", "radius to the edge", "m", "Distance from the centre of mass to the critical edge."},
    Term{"p", "rocking parameter", "rad/s",
         "√(m g R cos δ / I) about the critical edge; a scale of time, not a vibration frequency."},
    Term{
        "L, W, H", "length, width, height", "m",
        "Sides of the rectangle of least area around the rock seen from above, and height above the ground beside it."},
    Term{"V", "volume", "m³",
         "Of the closed surface. Where the base or flanks were not seen, the cap model that closed them is named."},
    Term{"σ", "standard uncertainty", "m",
         "One sigma of a target's centre from the scatter of its rays. Errors of the poses and of GNSS that all "
         "targets share are not in it."},
    Term{"views", "images that see a facet", "",
         "Number of images with an unobstructed ray to the facet, inside the frame, found by ray casting."},
    Term{"GSD", "ground sampling distance", "mm/px", "Size of the best image's pixel on the facet."},
    Term{"incidence", "incidence angle", "°",
         "Angle between the line of sight and the facet's normal; 0 is face on, 90 is grazing. The best view counts."},
    Term{"parallax", "parallax angle", "°", "Greatest angle between two lines of sight to the facet."},
    Term{"completeness", "complete share of the surface", "%",
         "Share of the surface's area that passes every gate of the coverage. It predicts what could be seen; it does "
         "not prove that a reconstruction succeeded."},
};

std::string sentence_of(std::span<const Pair> sentences, std::string_view code) {
  for (const auto& [known, sentence] : sentences)
    if (known == code) return std::string(sentence);
  std::string text(code);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

}  // namespace

std::string_view grade_label(survey::Grade grade) {
  return grade == survey::Grade::not_measurable ? "not measurable" : survey::name_of(grade);
}

std::string_view grade_meaning(survey::Grade grade) {
  switch (grade) {
    case survey::Grade::measured:
      return "Contact and sides were seen. The tipping figures can be used with their uncertainty.";
    case survey::Grade::bounded: return "The contact is known within an interval, so the tipping figures are limits.";
    case survey::Grade::screening:
      return "The contact was assumed at the base. The figures rank rocks for a visit; they are likely too large, "
             "because an unseen contact lies inside the visible rim.";
    case survey::Grade::not_measurable:
      return "Too little was seen of the rock or of its contact. No tipping figure is given.";
  }
  return "";
}

std::string_view state_meaning(survey::TargetState state) {
  switch (state) {
    case survey::TargetState::generated: return "first seen, not yet settled";
    case survey::TargetState::converging: return "the estimate is settling";
    case survey::TargetState::converged: return "located: further images no longer change it";
    case survey::TargetState::mapped: return "located, and its bounding cylinder is mapped";
    case survey::TargetState::deregistered: return "given up, for the reasons named";
  }
  return "";
}

std::string_view cap_meaning(survey::CapModel cap) {
  switch (cap) {
    case survey::CapModel::none: return "not closed";
    case survey::CapModel::plane: return "closed by a plane at the ground";
    case survey::CapModel::patch: return "closed by a smooth patch through the contact line";
    case survey::CapModel::wrap: return "closed by a wrapping surface";
  }
  return "";
}

std::string reason_sentence(std::string_view code) {
  return sentence_of(kReasons, code);
}
std::string coverage_sentence(std::string_view code) {
  return sentence_of(kCoverageReasons, code);
}

std::span<const Term> terms() {
  return kTerms;
}

}  // namespace cairn::report
