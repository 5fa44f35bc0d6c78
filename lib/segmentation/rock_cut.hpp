// Cuts located rocks out of a cloud: guided, one vertical cylinder a target.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "geometry/point_cloud.hpp"
#include "geometry/primitives.hpp"
#include "segmentation/labels.hpp"
#include "segmentation/local_ground.hpp"
#include "survey/contact.hpp"
#include "survey/ids.hpp"

namespace cairn::segmentation {

// Where to cut. Frame of the cloud (local ENU, m).
struct RockTarget {
  survey::TargetId id;
  std::string object_class;
  geometry::Vec2 centre = geometry::Vec2::Zero();
  double radius = 0.0;           // of the bounding cylinder, m; 0 = not known, default-radius-m is taken
  double low = 0.0, high = 0.0;  // its ends, m up; low >= high: not known
};

struct RockCutOptions {
  double default_radius_m = 0.75;       // of targets without a bounding cylinder
  double max_radius_m = 5.0;            // cylinders are cut down to this
  double margin_m = 0.25;               // added to the radius: the cylinder's own error and the rock's foot
  double annulus_width_m = 1.25;        // ground is fitted from the end of the margin outwards
  double min_height_m = 0.05;           // a rock point stands at least this above the ground
  double noise_factor = 3.0;            // and at least this many standard deviations of the ground's own noise
  double cluster_factor = 3.0;          // points nearer than this many spacings belong together
  std::int64_t min_points = 30;         // fewer rock points: rejected
  std::int64_t min_ground_points = 20;  // fewer in the annulus: rejected

  void visit(base::OptionVisitor& visitor);
};

// Where the rock meets the ground, seen from above, in one of 36 sectors about the rock's middle.
struct ContactSample {
  geometry::Vec3 position = geometry::Vec3::Zero();  // on the ground plane below the rim, m
  // The flank is there from the ground up, steeper than 60 deg: the crease itself was seen. Else the rim of
  // what was seen from above was dropped to the ground.
  bool observed = false;
};

// What the points of one rock say about how it was seen.
struct RockShape {
  double spacing = 0.0;                // median distance to the nearest neighbour, m
  double height = 0.0;                 // highest point above the ground, m
  double sides_seen_share = 0.0;       // of 36 sectors: those with a point in the lower half of the height
  std::vector<ContactSample> contact;  // by azimuth; sectors without points are left out

  [[nodiscard]] double observed_share() const;  // of the 36 sectors: contact observed
};

struct RockCut {
  survey::TargetId target;
  std::string object_class;
  std::vector<std::size_t> points;  // indices into the cloud, ascending
  GroundPlane ground;
  double threshold = 0.0;  // height above the ground from which a point counts as rock, m
  RockShape shape;
  std::vector<std::string> notes;  // codes: touches_crop, thin_ground
  std::string method = "height";   // height: by height above the ground; crease: by the crease at its foot
  survey::Contact contact;         // crease: the line where it rests; else empty
  double concavity = 0.0;          // crease: mean bend along the contact
  double noise = 0.0;              // crease: of the points about the surfaces at the contact, m
};

struct RockCuts {
  std::vector<RockCut> rocks;         // in order of target id
  std::vector<base::Reject> rejects;  // cloud_missing, no_points, ground_not_seen, not_above_ground, too_few_points,
                                      // duplicate_of_target
  std::vector<Label> labels;          // one a point
  std::vector<std::uint32_t> target_ids;  // one a point, kNoTarget outside rocks
  std::vector<float> probability;         // of the label, one a point, 0..1; empty where it was not judged
};

// points: of one rock; threshold [m]: height from which points counted as rock. Cost n log n.
[[nodiscard]] RockShape describe_rock(std::span<const geometry::Vec3> points, const GroundPlane& ground,
                                      double threshold);

// Each target on its own: the ground plane from the annulus, points above the threshold, their Euclidean
// clusters, and of these the one with most points inside the target's radius. A cluster
// shared by two targets goes to the one of lower id. Ground points of cylinder and annulus get label terrain.
// Limits: ground that a plane describes over about 3 m; rocks that touch others or shrubs are not split; the lowest
// `threshold` of the flank stays with the terrain. Cost: linear in the cloud plus n log n a rock; parallel
// over targets. Targets must have distinct ids below 2^32 - 1.
[[nodiscard]] RockCuts cut_rocks(const geometry::PointCloud& cloud, const std::vector<RockTarget>& targets,
                                 const RockCutOptions& options, base::RunContext& ctx);

// Writes the columns into the cloud: label, target_id and, where it was judged, probability.
void add_label_columns(geometry::PointCloud& cloud, const RockCuts& cuts);

}  // namespace cairn::segmentation
