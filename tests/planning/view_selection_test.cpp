#include "planning/view_selection.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/angle.hpp"
#include "base/random.hpp"
#include "camera/projection.hpp"
#include "planning/camera_aim.hpp"
#include "planning/cylinder_surface.hpp"
#include "support/brute_force_caster.hpp"
#include "support/meshes.hpp"

namespace {

using cairn::geometry::Vec3;
using cairn::planning::Demand;
using cairn::planning::select_views;
using cairn::planning::SelectionOptions;
using cairn::planning::Sight;
using cairn::planning::sights;
using cairn::planning::ViewGates;
using cairn::survey::Frame;

cairn::survey::Camera camera() {
  cairn::survey::Camera c;
  c.id = cairn::survey::CameraId(1);
  c.width_px = 4000;
  c.height_px = 3000;
  c.fx_px = c.fy_px = 3000;
  c.cx_px = 2000;
  c.cy_px = 1500;
  return c;
}

// Boulders as cylinders on a plate, some behind others; candidates on spheres about each.
struct Scene {
  cairn::geometry::TriangleMesh mesh;
  std::vector<Demand> demands;
  std::vector<Frame> candidates;

  explicit Scene(std::uint64_t record, std::size_t azimuths) {
    cairn::base::Random random(23, "boulders", record);
    // A plate over a part of the ground hides what is below it from steep views.
    mesh = cairn::testing::joined(cairn::testing::slab(-30, -30, 30, 30, 0, 10),
                                  cairn::testing::box(Vec3(-12, -12, 4), Vec3(12, 0, 4.2)));
    for (int b = 0; b < 3; ++b) {
      const cairn::geometry::VerticalCylinder cylinder{
          {random.uniform(-8, 8), random.uniform(-8, 8)}, 0.0, random.uniform(0.8, 2.5), random.uniform(0.5, 1.5)};
      const auto surface = cairn::planning::cylinder_surface(cylinder, 24, 4, 2);
      for (std::size_t f = 0; f < surface.side_facets; ++f) {
        Demand d;
        d.centre = surface.mesh.centroid(f);
        d.area_m2 = surface.mesh.area_vector(f).norm();
        d.normal = surface.mesh.area_vector(f).normalized();
        d.max_gsd_m = 0.01;
        demands.push_back(d);
      }
      mesh = cairn::testing::joined(mesh, surface.mesh);
      for (const double elevation : {20.0, 40.0, 65.0})
        for (std::size_t a = 0; a < azimuths; ++a) {
          const double azimuth = 6.283185307179586 * static_cast<double>(a) / static_cast<double>(azimuths);
          const double e = cairn::base::deg_to_rad(elevation);
          const Vec3 at = cylinder.centre() +
                          9.0 * Vec3(std::cos(e) * std::sin(azimuth), std::cos(e) * std::cos(azimuth), std::sin(e));
          const auto aim = cairn::planning::aim_at(at, cylinder.centre());
          Frame f;
          f.T_world_camera = cairn::planning::camera_pose(at, aim.heading_deg, aim.pitch_deg);
          candidates.push_back(f);
        }
    }
  }
};

TEST(Sights, EqualABruteForceCaster) {
  const Scene scene(0, 6);
  const cairn::visibility::Scene embree(scene.mesh);
  const ViewGates gates;
  const auto seen = sights(scene.candidates, camera(), scene.demands, embree, gates, 100.0, 0.0);
  std::size_t hidden = 0, compared = 0;
  for (std::size_t v = 0; v < scene.candidates.size(); ++v) {
    const auto& pose = scene.candidates[v].T_world_camera;
    std::set<std::uint32_t> listed;
    for (const Sight& s : seen[v]) listed.insert(s.demand);
    for (std::size_t i = 0; i < scene.demands.size(); ++i) {
      const Demand& d = scene.demands[i];
      const Vec3 ray = d.centre - pose.translation;
      if (std::abs(d.normal.dot(ray)) < 1e-3 * ray.norm()) continue;  // silhouettes
      const auto pixel = cairn::camera::project_world(camera(), pose, d.centre);
      const bool in_front = d.normal.dot(ray) < 0.0 && pixel && cairn::camera::inside_image(camera(), *pixel);
      const bool blocked =
          in_front && cairn::testing::first_hit(scene.mesh, pose.translation, ray, 1.0 - 1e-3).has_value();
      EXPECT_EQ(listed.count(static_cast<std::uint32_t>(i)) == 1, in_front && !blocked) << v << " " << i;
      hidden += blocked ? 1 : 0;
      ++compared;
    }
  }
  EXPECT_GT(hidden, 20U);
  EXPECT_GT(compared, 5000U);
}

// An independent greedy that looks at every candidate in every round and counts what passes the gates, over more
// candidates than the planner has.
std::size_t exhaustive_greedy(const std::vector<Demand>& demands, const ViewGates& gates,
                              const std::vector<std::vector<Sight>>& candidates, double target) {
  struct Seen {
    std::int64_t views = 0, steep = 0;
    bool fine = false;
    std::vector<Vec3> directions;
  };
  std::vector<Seen> state(demands.size());
  const auto progress = [&](const Seen& s) {
    double widest = 0.0;
    for (const Vec3& a : s.directions)
      for (const Vec3& b : s.directions) widest = std::max(widest, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
    return std::min(1.0, static_cast<double>(s.views) / static_cast<double>(gates.min_views)) +
           std::min(1.0, static_cast<double>(s.steep) / 2.0) + (s.fine ? 1.0 : 0.0) +
           std::min(1.0, cairn::base::rad_to_deg(widest) / gates.min_parallax_deg);
  };
  const auto with = [](Seen s, const Sight& sight) {
    ++s.views;
    s.steep += sight.steep_enough ? 1 : 0;
    s.fine = s.fine || sight.fine_enough;
    if (s.directions.size() < 4)
      s.directions.emplace_back(static_cast<double>(sight.x), static_cast<double>(sight.y),
                                static_cast<double>(sight.z));
    return s;
  };
  double total = 0.0;
  for (const Demand& d : demands) total += d.area_m2;
  for (std::size_t chosen = 0; chosen < 200; ++chosen) {
    double passing = 0.0;
    for (std::size_t i = 0; i < demands.size(); ++i)
      if (progress(state[i]) > 4.0 - 1e-9) passing += demands[i].area_m2;
    if (passing >= target * total) return chosen;
    double best_gain = 0.0;
    std::size_t best = 0;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      double gain = 0.0;
      for (const Sight& s : candidates[c])
        gain += demands[s.demand].area_m2 * (progress(with(state[s.demand], s)) - progress(state[s.demand]));
      if (gain > best_gain) {
        best_gain = gain;
        best = c;
      }
    }
    if (best_gain <= 0.0) break;
    for (const Sight& s : candidates[best]) state[s.demand] = with(state[s.demand], s);
  }
  return 200;
}

TEST(ViewSelection, ReachesItsTargetWithFewViews) {
  const ViewGates gates;
  SelectionOptions options;
  for (std::uint64_t run = 0; run < 4; ++run) {
    const Scene planned(run, 12), dense(run, 24);
    const cairn::visibility::Scene embree(planned.mesh);
    const auto few = sights(planned.candidates, camera(), planned.demands, embree, gates, 100.0);
    const auto many = sights(dense.candidates, camera(), dense.demands, embree, gates, 100.0);
    // Boulders stand in one another and below the plate: a part of their walls no view can reach.
    options.target = 0.97 * select_views(planned.demands, gates, {}, few, {0.0, 0, true}).share_reachable;
    EXPECT_GT(options.target, 0.85);
    const auto selection = select_views(planned.demands, gates, {}, few, options);
    ASSERT_FALSE(selection.chosen.empty());
    EXPECT_EQ(selection.share_before, 0.0);
    EXPECT_GE(selection.share.back(), options.target) << run;
    EXPECT_GE(selection.share_reachable, selection.share.back() - 1e-9);
    const std::size_t oracle = exhaustive_greedy(dense.demands, gates, many, options.target);
    EXPECT_LE(static_cast<double>(selection.chosen.size()), 1.3 * static_cast<double>(oracle)) << run;
    RecordProperty("views_" + std::to_string(run),
                   std::to_string(selection.chosen.size()) + " of " + std::to_string(oracle));
    // Lazy and exhaustive rounds choose the same; lazy computes fewer gains.
    SelectionOptions every = options;
    every.lazy = false;
    const auto exhaustive = select_views(planned.demands, gates, {}, few, every);
    EXPECT_EQ(selection.chosen, exhaustive.chosen);
    EXPECT_LT(selection.evaluations, exhaustive.evaluations);
  }
}

TEST(ViewSelection, StopsWhereNothingIsGainedAndCountsWhatIsThere) {
  Demand seen, hidden;
  seen.area_m2 = 3.0;
  hidden.area_m2 = 1.0;
  const std::vector<Demand> demands{seen, hidden};
  const auto from = [](float x) { return std::vector<Sight>{{0, x, 0.0F, std::sqrt(1.0F - x * x), true, true}}; };
  const std::vector<std::vector<Sight>> recorded{from(0.0F), from(0.1F)}, candidates{from(0.5F), from(-0.5F)};
  ViewGates gates;
  SelectionOptions options;
  const auto selection = select_views(demands, gates, recorded, candidates, options);
  EXPECT_EQ(selection.share_before, 0.0);
  EXPECT_NEAR(selection.share_reachable, 0.75, 1e-12);
  ASSERT_GE(selection.chosen.size(), 1U);
  EXPECT_NEAR(selection.share.front(), 0.75, 1e-12);
  // Parallax is a gate of its own: three views from one place do not pass.
  const std::vector<std::vector<Sight>> same{from(0.2F), from(0.2F), from(0.2F)};
  EXPECT_EQ(select_views(demands, gates, same, {}, options).share_before, 0.0);
  gates.min_parallax_deg = 0.0;
  EXPECT_NEAR(select_views(demands, gates, same, {}, options).share_before, 0.75, 1e-12);
  // Nothing to do.
  EXPECT_TRUE(select_views({}, gates, {}, {}, options).chosen.empty());
}

TEST(ShortTour, IsShorterThanInAnyOrderAndVisitsAllOnce) {
  cairn::base::Random random(3, "tour", 0);
  std::vector<Vec3> places;
  for (int i = 0; i < 40; ++i)
    places.emplace_back(random.uniform(0, 100), random.uniform(0, 100), random.uniform(5, 20));
  const auto tour = cairn::planning::short_tour(places, Vec3(0, 0, 10));
  EXPECT_EQ(std::set<std::size_t>(tour.begin(), tour.end()).size(), 40U);
  const auto length = [&](const std::vector<std::size_t>& order) {
    double sum = (places[order[0]] - Vec3(0, 0, 10)).norm();
    for (std::size_t i = 1; i < order.size(); ++i) sum += (places[order[i]] - places[order[i - 1]]).norm();
    return sum;
  };
  // No reversal of a stretch shortens it.
  for (std::size_t i = 0; i < 40; ++i)
    for (std::size_t j = i + 1; j < 40; ++j) {
      auto other = tour;
      std::reverse(other.begin() + static_cast<std::ptrdiff_t>(i), other.begin() + static_cast<std::ptrdiff_t>(j) + 1);
      EXPECT_GE(length(other), length(tour) - 1e-6);
    }
  EXPECT_TRUE(cairn::planning::short_tour({}, Vec3::Zero()).empty());
}

}  // namespace
