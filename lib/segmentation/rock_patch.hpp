// Rock, pedestal, basal contact and terrain in the points around one rock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "geometry/vec.hpp"
#include "segmentation/contact_line.hpp"
#include "segmentation/labels.hpp"
#include "segmentation/local_ground.hpp"
#include "survey/contact.hpp"

namespace cairn::segmentation {

struct RockPatchOptions {
  double step_spacings = 2.7;         // first resolution over the spacing of the points; the second is half of it
  std::int64_t max_nodes = 60'000;    // the first resolution is made coarser until the patch has no more
  double bend_reach_spacings = 10.0;  // over which a bend is felt, either way
  double margin_m = 0.25;             // beyond the radius everything is known to be no rock from here on
  double min_height_m = 0.15;         // what stands less above its surroundings is no rock
  double concavity_scale = 0.05;      // bend at which the cost of a cut falls to 1 / e
  double least_concavity = 0.045;     // mean bend along the contact below which no contact was found
  std::int64_t min_points = 200;      // fewer points on the rock: rejected

  void visit(base::OptionVisitor& visitor);
};

// A point a person knows to be rock, or not.
struct RockPick {
  geometry::Vec3 position = geometry::Vec3::Zero();  // m, frame of the points
  bool rock = true;
};

// Another rock nearby: what is nearer to it (over its radius) is not this rock.
struct OtherRock {
  geometry::Vec2 centre = geometry::Vec2::Zero();  // m
  double radius = 0.0;                             // m, > 0
};

struct PatchInput {
  std::span<const geometry::Vec3> points;          // m, z up; those that are not finite are left out
  geometry::Vec2 centre = geometry::Vec2::Zero();  // of an upright cylinder that holds the rock
  double radius = 0.0;                             // of it, m, > 0
  // Where the cylinder ends, m up; low >= high: not known. The foot is sought near its lower end.
  double low = 0.0, high = 0.0;
  std::vector<RockPick> picks;  // obeyed
  std::vector<OtherRock> others;
  survey::Contact contact;  // digitised: taken as it stands; empty = to be found
};

struct PatchResult {
  // Why there is no rock here; "" = there is. no_points, two_points, planar, ground_not_seen, not_above_ground,
  // not_a_surface (points all through a volume: shrubs, noise), no_contact (no crease closes around a foot),
  // too_few_points.
  std::string reason, message;
  std::vector<Label> labels;       // one a point; unlabelled where the patch does not reach
  std::vector<float> probability;  // of the label given, 0..1
  survey::Contact contact;
  ContactLine line;  // with the surfaces at each vertex; empty with a digitised contact
  GroundPlane ground;
  double spacing = 0.0;            // median distance to the nearest neighbour, m
  double noise = 0.0;              // of the points about the surfaces at the contact, m
  double concavity = 0.0;          // mean bend along the cut
  double height = 0.0;             // of the rock's top above the ground, m
  std::vector<std::string> notes;  // codes: touches_crop, hidden_base, weak_contact

  [[nodiscard]] bool found() const { return reason.empty(); }
};

// One rock. The points are thinned to a working resolution; every node gets the concavity of its surroundings
// (PatchGraph); cuts of least cost that prefer concave places (minimum_cut) are sought between lower and upper
// bounds that slide down the rock; of these the one is taken that is concave all along. A crease at the foot of a
// pedestal is left for a good one above it. The contact is then located where flank and seat meet (fit_contact), and
// the points near it are labelled anew by the surface they lie on. About 10 us a point.
[[nodiscard]] PatchResult segment_patch(const PatchInput& input, const RockPatchOptions& options);

}  // namespace cairn::segmentation
