// Close-range clouds of simulated rocks on pedestals, with everything that is true of them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fragility/tipping.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/point_cloud.hpp"
#include "geometry/primitives.hpp"
#include "geometry/triangle_mesh.hpp"
#include "survey/contact.hpp"
#include "survey/truth.hpp"

namespace cairn::testing {

// Never drawn unless named: methods are tuned on the other families and then judged on this one.
inline constexpr const char* kHeldOutFamily = "slab";

// What hides the foot of a rock from the cameras.
enum class Hiding {
  drawn,   // half of the seeds nothing, a quarter brush, a quarter sector
  none,    // three rings of views, all of them free
  brush,   // the same, with shrubs before the contact (they stand in the cloud too, label 0)
  sector,  // views from a sector of 130 to 220 degrees are missing
  absent,  // no views: every surface that is open to the air is sampled
};

// Members of 0 (or "") are drawn from the seed.
struct RockScanOptions {
  std::string family;     // "" = one of those not held out
  double height_m = 0.0;  // of the rock; drawn from 0.8..2.5
  Hiding hiding = Hiding::drawn;
  double spacing_m = 0.01;     // of the points
  double noise_m = 0.005;      // along the normal
  double outlier_share = 0.0;  // of points thrown off the surface
  double contact_share = 0.0;  // bearing area over that inside the rim; drawn: 0.45..1 on one pad, else pads
  int contact_pads = 0;        // drawn: one in four of five rocks, else two to four
  double margin_m = 0.6;       // of ground and pedestal round the rock
  double edge_m = 0.02;        // of the true mesh
  std::uint64_t sampling = 0;  // another number: the same rock and views, other points and noise
};

struct RockScan {
  std::uint64_t seed = 0;
  std::string family;
  Hiding hiding = Hiding::none;
  // Positions and colours only: nothing in it tells the truth.
  geometry::PointCloud cloud;
  // Of the points, as `cairn segment` writes them: 0 none, 1 terrain, 2 rock, 3 pedestal, 4 basal contact (rock or
  // pedestal within 1.5 spacings of the rim). In `surface` the basal points keep the body they lie on.
  std::vector<std::uint8_t> label, surface;
  std::vector<std::uint32_t> target_id;  // the rock's id (1) on rock and pedestal, else 4294967295
  // World = the cloud's frame, m. Closed rings, counter-clockwise from above: the visible crease, and what bears.
  std::vector<std::vector<geometry::Vec3>> rim, bearing;
  geometry::TriangleMesh body, pedestal;  // closed, outward
  geometry::MassProperties mass;          // of the body; unit density
  fragility::TippingResult on_rim, on_bearing;
  double spacing_m = 0.0, noise_m = 0.0;
  // Share of the rim's length at which the cloud lacks rock or pedestal within three spacings, 0..1.
  double hidden_share = 0.0;
  geometry::VerticalCylinder cylinder;  // smallest upright one round the rock

  [[nodiscard]] double alpha_rim_deg() const;      // 0 where the rim does not hold the rock
  [[nodiscard]] double alpha_bearing_deg() const;  // the same of the bearing
  // The true rim (or bearing) as a contact line, every vertex observed.
  [[nodiscard]] survey::Contact contact(bool of_bearing = false) const;
  // The cloud with the columns label and target_id.
  [[nodiscard]] geometry::PointCloud labelled() const;
  [[nodiscard]] survey::Truth truth() const;  // one object, no mesh named
};

// The same seed and options give the same bytes. About 130 000 points and 2 CPU seconds at the defaults.
[[nodiscard]] RockScan make_rock_scan(std::uint64_t seed, const RockScanOptions& options = {});

// Many rocks on rough ground, for finding them without being told where: on pedestals, on the ground, in touching
// pairs, with shrubs between them that are no rocks.
struct RockSceneOptions {
  std::int64_t on_pedestals = 10, on_ground = 8, touching_pairs = 3, shrubs = 8;
  std::string family;  // "" = all families not held out
  double size_min_m = 0.6, size_max_m = 2.2;
  double spacing_m = 0.03, noise_m = 0.006;
  double room_m = 4.5;    // side of the square of ground an object has on average
  double relief_m = 1.2;  // of the ground over the scene
  double slope = 0.08;    // of the ground, rise per metre
};

struct RockScene {
  std::uint64_t seed = 0;
  geometry::PointCloud cloud;  // positions and colours
  std::vector<std::uint8_t> label;
  std::vector<std::uint32_t> target_id;        // of rocks and their pedestals
  std::vector<survey::TruthObject> rocks;      // ascending id; shrubs are not among them
  std::vector<geometry::TriangleMesh> bodies;  // of the rocks, in their order
  [[nodiscard]] geometry::PointCloud labelled() const;
};

// 24 rocks and about 1.4 million points in 18 CPU seconds at the defaults.
[[nodiscard]] RockScene make_rock_scene(std::uint64_t seed, const RockSceneOptions& options = {});

}  // namespace cairn::testing
