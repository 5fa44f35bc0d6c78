// Which views to add so that a surface passes its coverage gates: next best view by submodular gain.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "geometry/vec.hpp"
#include "survey/camera.hpp"
#include "survey/frame.hpp"
#include "visibility/scene.hpp"

namespace cairn::planning {

// A piece of surface that is to pass.
struct Demand {
  geometry::Vec3 centre = geometry::Vec3::Zero();   // local ENU, m
  geometry::Vec3 normal = geometry::Vec3::UnitZ();  // outward, unit
  double area_m2 = 0.0;
  double max_gsd_m = 0.0;  // of the best view; 0 = not asked for
  double weight = 1.0;     // of a square metre, >= 0
  std::size_t group = 0;   // each group is to reach the target by itself
};

// The gates of a coverage audit.
struct ViewGates {
  std::int64_t min_views = 3;
  double max_incidence_deg = 60.0;  // in two views (in one where min_views is 1)
  double min_parallax_deg = 5.0;
};

// One view sees one demand.
struct Sight {
  std::uint32_t demand = 0;
  float x = 0.0F, y = 0.0F, z = 0.0F;  // unit direction from the demand to the camera
  bool steep_enough = false;           // incidence within the gate
  bool fine_enough = false;            // ground sampling distance within the demand's limit
};

// What each view sees of the demands: inside the frame with this margin (fraction), facing, and not blocked on the
// segment from the camera to the centre without its last `end_gap`. The ground sampling distance is that of module
// `coverage`, the distortion's magnification left out. Demands beyond `max_range` [m] are not looked at.
// Cost: views x demands within the range to the east and west. Results do not depend on threads.
[[nodiscard]] std::vector<std::vector<Sight>> sights(std::span<const survey::Frame> views, const survey::Camera& camera,
                                                     std::span<const Demand> demands, const visibility::Scene& scene,
                                                     const ViewGates& gates, double max_range,
                                                     double frame_margin = 0.02, double end_gap = 1e-3);

struct SelectionOptions {
  double target = 0.95;          // share of each group's area that is to pass, as far as the candidates allow
  std::size_t max_views = 1000;  // most that are chosen
  bool lazy = true;              // false: every candidate's gain is computed in every round
};

struct Selection {
  std::vector<std::size_t> chosen;  // candidates in the order of choice
  std::vector<double> share;        // of the area of the group that has least of it passing, after each
  double share_before = 0.0, share_reachable = 0.0;                // the same with none, and with all candidates
  std::vector<double> group_before, group_reachable, group_after;  // of each group; 1 where it has no area
  std::size_t evaluations = 0;                                     // gains computed
};

// Greedy choice of the candidate of greatest gain until every group has reached the target (or what all candidates
// together can reach of it), nothing is gained, or max_views are chosen. Demands of a group that is done gain nothing
// more. The gain is that of a monotone submodular function: per demand, weight x area x the mean of
//   min(views, k) / k,  min(steep views, 2) / 2 (1 where k = 1),  fine view or not,  min(direction cells, 2) / 2
// with k = min_views and direction cells of 30 deg of azimuth by 22.5 deg of elevation, as a stand-in for parallax
// (which by itself is not submodular). So a gain computed earlier bounds the present one, and candidates are evaluated
// only while their bound is the best (Minoux 1978): the same choice as the exhaustive rounds. The greedy value is at
// least 1 - 1/e of the best for the same number of views (Nemhauser, Wolsey, Fisher 1978). Whether a demand passes is
// decided by the gates themselves. Ties go to the lower index.
[[nodiscard]] Selection select_views(std::span<const Demand> demands, const ViewGates& gates,
                                     std::span<const std::vector<Sight>> already,
                                     std::span<const std::vector<Sight>> candidates, const SelectionOptions& options);

// Order of visits with a short way: nearest neighbour from `start`, then 2-opt until nothing improves (at most 50
// rounds). Open: it does not return. Cost n^2 a round.
[[nodiscard]] std::vector<std::size_t> short_tour(std::span<const geometry::Vec3> places, const geometry::Vec3& start);

}  // namespace cairn::planning
