#include "simulation/simulate.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "simulation/flight.hpp"
#include "simulation/pose_noise.hpp"

namespace {

using namespace cairn;
using namespace cairn::simulation;
using geometry::Vec2;
using geometry::Vec3;

ObjectSpec ellipsoid(const char* name, const Vec2& place, const Vec3& size, bool sought = true) {
  ObjectSpec object;
  object.name = name;
  object.object_class = sought ? "pbr" : "boulder";
  object.sought = sought;
  object.position = place;
  object.shape.kind = ShapeKind::ellipsoid;
  object.shape.size_m = size;
  return object;
}

// Level ground, one search flight at 12 m.
Scene level_scene() {
  Scene scene;
  scene.name = "level";
  scene.terrain.min = {-30, -30};
  scene.terrain.max = {30, 30};
  scene.terrain.cell_m = 2.0;
  scene.cameras = {r200_camera()};
  scene.objects = {ellipsoid("a", {0, 0}, {2, 1.5, 1.8}), ellipsoid("b", {6, 4}, {1, 1, 2})};
  Flight flight;
  flight.area = {{-10, -10}, {10, -10}, {10, 10}, {-10, 10}};
  flight.lane_spacing_m = 5.0;
  flight.height_m = 12.0;
  flight.rate_hz = 4.0;
  scene.flights = {flight};
  return scene;
}

Recording made(const Scene& scene, std::uint64_t seed = 1) {
  base::RunContext ctx;
  return simulate(scene, seed, ctx);
}

TEST(Simulate, SameSeedSameRecordingOnAnyNumberOfThreads) {
  Scene scene = level_scene();
  scene.pose_noise.white_xy_m = 0.1;
  scene.detector.jitter_px = 1.0;
  scene.detector.miss_rate = 0.2;
  scene.detector.false_per_image = 0.5;
  const auto once = [&](int threads, std::uint64_t seed) {
    const base::ThreadLimit limit(threads);
    return made(scene, seed);
  };
  const Recording a = once(1, 3), b = once(4, 3), c = once(4, 4);
  ASSERT_EQ(a.survey.detections.size(), b.survey.detections.size());
  EXPECT_EQ(a.survey.detections, b.survey.detections);
  ASSERT_EQ(a.truth.boxes.size(), b.truth.boxes.size());
  for (std::size_t i = 0; i < a.truth.boxes.size(); ++i) {
    EXPECT_EQ(a.truth.boxes[i].box, b.truth.boxes[i].box);
    EXPECT_EQ(a.truth.boxes[i].visible_share, b.truth.boxes[i].visible_share);
  }
  for (std::size_t i = 0; i < a.survey.frames.size(); ++i)
    EXPECT_EQ(a.survey.frames[i].T_world_camera.translation, b.survey.frames[i].T_world_camera.translation);
  EXPECT_NE(a.survey.detections, c.survey.detections);
  // The truth of the scene does not move with the seed.
  EXPECT_EQ(a.truth.frames[7].T_world_camera.translation, c.truth.frames[7].T_world_camera.translation);
  EXPECT_EQ(a.truth.objects[0].centre_of_mass, c.truth.objects[0].centre_of_mass);
}

TEST(Simulate, WithoutNoiseDetectionsAreTheTrueBoxes) {
  const Recording r = made(level_scene());
  std::map<std::pair<std::int64_t, std::int64_t>, geometry::PixelBox> truth;
  for (const auto& b : r.truth.boxes) truth[{b.frame.value, b.object.value}] = b.box;
  ASSERT_GT(r.survey.detections.size(), 100U);
  for (std::size_t i = 0; i < r.survey.detections.size(); ++i) {
    const auto& d = r.survey.detections[i];
    const auto& o = r.truth.detections[i];
    ASSERT_EQ(o.detection, d.id);
    EXPECT_EQ(d.box, (truth.at({d.frame.value, o.object.value})));
  }
  for (std::size_t i = 0; i < r.survey.frames.size(); ++i)
    EXPECT_EQ(r.survey.frames[i].T_world_camera.translation, r.truth.frames[i].T_world_camera.translation);
}

TEST(Simulate, CylinderOfAnEllipsoidOnLevelGroundIsItsOwn) {
  const Recording r = made(level_scene());
  const auto& c = r.truth.objects[0].cylinder;
  // The mesh is inscribed in the ellipsoid with edges of a fiftieth of its size: 1e-2 m.
  constexpr double kFacets = 1e-2;
  EXPECT_NEAR(c.radius, 1.0, kFacets);
  EXPECT_NEAR(c.top, 1.8, kFacets);
  EXPECT_NEAR(c.bottom, 0.0, kFacets);
  EXPECT_NEAR((c.centre() - Vec3(0, 0, 0.9)).norm(), 0.0, kFacets);
}

TEST(Simulate, BuriedPartsDoNotCount) {
  Scene scene = level_scene();
  scene.objects = {ellipsoid("half", {0, 0}, {2, 2, 2})};
  scene.objects[0].sink_m = 1.5;
  const auto object = made(scene).truth.objects[0];
  constexpr double kFacets = 1e-2;  // m
  EXPECT_NEAR(object.cylinder.bottom, 0.0, kFacets);
  EXPECT_NEAR(object.cylinder.top, 0.5, kFacets);
  EXPECT_NEAR(object.cylinder.radius, std::sqrt(1.0 - 0.25), kFacets);  // the section 0.5 m above the middle
}

TEST(Simulate, ObjectsRestOnRoughGround) {
  Scene scene = level_scene();
  scene.terrain.relief_m = 4.0;
  scene.terrain.wavelength_m = 15.0;
  scene.terrain.cell_m = 0.5;
  ObjectSpec boxes;
  boxes.object_class = "block";
  boxes.shape.kind = ShapeKind::box;
  boxes.shape.size_m = {1.2, 1.0, 0.8};
  Scatter scatter;
  scatter.count = 40;
  scatter.area = {{-20, -20}, {20, -20}, {20, 20}, {-20, 20}};
  scatter.spacing_m = 3.0;
  scatter.max_slope_deg = 25.0;
  boxes.scatter = scatter;
  scene.objects = {boxes};
  const Recording r = made(scene);
  const Ground ground(r.terrain);
  ASSERT_EQ(r.shapes.size(), 40U);
  for (std::size_t i = 0; i < r.shapes.size(); ++i) {
    const auto& vertices = r.shapes[i].body.vertices;
    double lowest = 1e9, highest_base = -1e9;
    for (const Vec3& v : vertices) lowest = std::min(lowest, v.z());
    for (const Vec3& v : vertices)
      if (v.z() < lowest + 1e-6) highest_base = std::max(highest_base, v.z() - *ground.height(v.head<2>()));
    constexpr double kGround = 1e-3;  // m: single precision of the ground's ray casting
    EXPECT_NEAR(highest_base, 0.0, kGround) << "no part of the base is above the ground, one touches it";
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GE((r.truth.objects[i].cylinder.axis - r.truth.objects[j].cylinder.axis).norm(), 3.0 - 0.1);
  }
}

TEST(Simulate, WhatStandsInFrontHides) {
  Scene scene = level_scene();
  // A wall south of the second of two like bodies; a camera south of it looks north.
  scene.objects = {ellipsoid("free", {-3, 0}, {1, 1, 1}), ellipsoid("hidden", {3, 0}, {1, 1, 1})};
  ObjectSpec wall = ellipsoid("wall", {3, -2}, {3, 0.2, 3}, false);
  wall.shape.kind = ShapeKind::box;
  wall.shape.azimuth_deg = 90.0;
  scene.objects.push_back(wall);
  Flight look;
  look.kind = FlightKind::waypoints;
  look.waypoints = {{0, -12, 2}, {0, -11.5, 2}};
  look.gamma_deg = 8.0;
  look.heading_deg = 0.0;
  scene.flights = {look};
  const Recording r = made(scene);
  ASSERT_GE(r.truth.boxes.size(), 3U);
  for (const auto& box : r.truth.boxes) {
    if (box.object.value == 1) {
      EXPECT_EQ(box.visible_share, 1.0);
    }
    EXPECT_NE(box.object.value, 2) << "wholly hidden objects have no box";
  }
  scene.objects[2].shape.size_m = {3, 0.2, 0.8};  // now the line of sight passes over its top half
  bool partly = false;
  for (const auto& box : made(scene).truth.boxes)
    if (box.object.value == 2 && box.visible_share > 0.05 && box.visible_share < 0.95) partly = true;
  EXPECT_TRUE(partly);
}

TEST(Simulate, SearchIsInterruptedByOneCircleAboutEachSoughtObject) {
  Scene scene = level_scene();
  EstimationCircles circles;
  circles.seen_s = 1.0;
  circles.gamma_0_deg = 45.0;
  scene.flights[0].circles = circles;
  const Recording r = made(scene);
  std::map<std::int64_t, std::vector<std::size_t>> frames;
  for (std::size_t i = 0; i < r.circled.size(); ++i)
    if (r.circled[i].valid()) frames[r.circled[i].value].push_back(i);
  ASSERT_EQ(frames.size(), 2U);
  for (const auto& [id, own] : frames) {
    const Vec3 centre = r.truth.objects[static_cast<std::size_t>(id - 1)].cylinder.centre();
    const double radius = 12.0 - centre.z();  // gamma_0 = 45 deg
    std::vector<int> sector(12, 0);
    for (const std::size_t i : own) {
      const Vec3 way = r.truth.frames[i].T_world_camera.translation - centre;
      EXPECT_NEAR(r.truth.frames[i].T_world_camera.translation.z(), 12.0, 1e-9);
      if (std::abs(way.head<2>().norm() - radius) > 1e-6) continue;
      ++sector[static_cast<std::size_t>(base::azimuth_deg(way.x(), way.y()) / 30.0)];
    }
    EXPECT_GT(*std::min_element(sector.begin(), sector.end()), 0) << "seen from all sides";
  }
}

TEST(Flight, LanesCoverTheAreaAtAnyAzimuth) {
  const geometry::Ring area{{0, 0}, {40, 5}, {45, 30}, {10, 38}};
  for (const double azimuth : {0.0, 30.0, 90.0, 145.0}) {
    const auto lanes = lawn_mower_lanes(area, azimuth, 7.0);
    base::Random random(5, "lanes", 0);
    for (int i = 0; i < 2000; ++i) {
      const Vec2 p(random.uniform(0, 45), random.uniform(0, 38));
      if (!geometry::contains(area, p)) continue;
      double nearest = 1e9;
      for (const auto& [a, b] : lanes) {
        const double t = std::clamp((p - a).dot(b - a) / std::max(1e-12, (b - a).squaredNorm()), 0.0, 1.0);
        nearest = std::min(nearest, (p - a - t * (b - a)).norm());
      }
      EXPECT_LE(nearest, 3.5 + 1e-9) << azimuth;
    }
  }
}

TEST(Flight, PhotographsAreEvenlySpacedAndVideoIsEvenlyTimed) {
  Scene scene = level_scene();
  Recording video = made(scene);
  for (std::size_t i = 1; i < video.survey.frames.size(); ++i)
    ASSERT_EQ(video.survey.frames[i].time_ns - video.survey.frames[i - 1].time_ns, 250'000'000);
  scene.flights[0].rate_hz = 0.0;
  scene.flights[0].photo_spacing_m = 2.5;
  const Recording photos = made(scene);
  ASSERT_GT(photos.survey.frames.size(), 20U);
  for (std::size_t i = 1; i < photos.survey.frames.size(); ++i) {
    const Vec3 step =
        photos.truth.frames[i].T_world_camera.translation - photos.truth.frames[i - 1].T_world_camera.translation;
    EXPECT_LE(step.norm(), 2.5 + 1e-9);
    EXPECT_GE(step.lpNorm<1>(), 2.5 - 1e-9);  // round a corner the way is the sum of both legs
  }
}

TEST(Flight, OrbitLooksAtItsCentreFromGamma0) {
  Scene scene = level_scene();
  Flight orbit;
  orbit.kind = FlightKind::orbit;
  orbit.about = "a";
  orbit.height_m = 10.0;
  orbit.gamma_0_deg = 60.0;
  orbit.aim_at_centre = true;
  scene.flights = {orbit};
  const Recording r = made(scene);
  const Vec3 centre = r.truth.objects[0].cylinder.centre();
  for (const auto& frame : r.truth.frames) {
    const Vec3 way = centre - frame.T_world_camera.translation;
    EXPECT_NEAR(base::rad_to_deg(std::atan2(-way.z(), way.head<2>().norm())), 60.0, 1e-6);
    EXPECT_NEAR(frame.T_world_camera.rotation.col(2).dot(way.normalized()), 1.0, 1e-9);
  }
}

// The noise's statistics over many draws against the sigma that frames.csv states.
TEST(PoseNoise, ScatterEqualsTheStatedSigma) {
  PoseNoise noise;
  noise.white_xy_m = 0.05;
  noise.white_z_m = 0.1;
  noise.constant_xy_m = 0.6;
  noise.constant_z_m = 0.9;
  noise.walk_xy_m_sqrt_s = 0.05;
  noise.walk_z_m_sqrt_s = 0.03;
  noise.attitude_deg = 0.5;
  noise.attitude_correlation_s = 2.0;
  noise.attitude_constant_deg = 0.4;
  std::vector<double> times;
  for (int i = 0; i < 400; ++i) times.push_back(0.25 * i);
  const std::vector<geometry::RigidTransform> poses(times.size());
  constexpr std::uint64_t kSeeds = 2000;
  for (const std::size_t at : {std::size_t{0}, std::size_t{100}, std::size_t{399}}) {
    double xy = 0.0, z = 0.0, angle = 0.0;
    NoisyPose last;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      last = noisy_poses(noise, seed, times, poses)[at];
      const Vec3 p = last.T_world_camera.translation;
      xy += p.head<2>().squaredNorm() / 2.0;
      z += p.z() * p.z();
      const double turned = geometry::rotation_angle(last.T_world_camera.rotation);
      angle += turned * turned / 3.0;
    }
    // Relative standard error of a sigma from n draws: 1 / sqrt(2 n) = 1.6 %; four of them.
    constexpr double kSpread = 4.0 * 0.016;
    EXPECT_NEAR(std::sqrt(xy / kSeeds) / last.sigma_xy_m, 1.0, kSpread) << at;
    EXPECT_NEAR(std::sqrt(z / kSeeds) / last.sigma_z_m, 1.0, kSpread) << at;
    EXPECT_NEAR(base::rad_to_deg(std::sqrt(angle / kSeeds)) / last.sigma_rot_deg, 1.0, kSpread) << at;
  }
}

TEST(Detector, RatesAndJitterAreAsStated) {
  Scene scene = level_scene();
  scene.detector.jitter_px = 1.5;
  scene.detector.jitter_share = 0.02;
  scene.detector.miss_rate = 0.25;
  scene.detector.miss_run_frames = 3.0;
  scene.detector.false_per_image = 0.2;
  Clutter clutter;
  clutter.position = Vec2(-4, 2);
  clutter.hit_probability = 0.4;
  scene.detector.clutter = {clutter};
  base::RunContext ctx;
  const Rehearsal rehearsal(scene, ctx);
  double possible = 0, found = 0, sporadic = 0, frames = 0, places = 0, runs = 0, missed = 0;
  double sum = 0, squares = 0, edges = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Recording r = rehearsal.record(seed);
    frames += static_cast<double>(r.survey.frames.size());
    std::map<std::pair<std::int64_t, std::int64_t>, const survey::Detection*> of;
    for (std::size_t i = 0; i < r.truth.detections.size(); ++i) {
      const auto& o = r.truth.detections[i];
      if (o.object.valid()) of[{o.object.value, r.survey.detections[i].frame.value}] = &r.survey.detections[i];
      sporadic += !o.object.valid() && o.clutter < 0 ? 1 : 0;
      places += o.clutter == 0 ? 1 : 0;
    }
    std::map<std::int64_t, bool> before;
    for (const auto& box : r.truth.boxes) {
      if (!box.whole) continue;
      ++possible;
      const auto it = of.find({box.object.value, box.frame.value});
      const bool lost = it == of.end();
      found += lost ? 0 : 1;
      missed += lost ? 1 : 0;
      runs += lost && !before[box.object.value] ? 1 : 0;
      before[box.object.value] = lost;
      // Boxes near the border are cut by it.
      if (lost || box.box.xmin < 20 || box.box.ymin < 20 || box.box.xmax > 620 || box.box.ymax > 460) continue;
      const double e = (it->second->box.xmin - box.box.xmin) / std::hypot(1.5, 0.02 * box.box.width());
      sum += e;
      squares += e * e;
      ++edges;
    }
  }
  ASSERT_GT(possible, 5000);
  // Runs of three make misses of one run alike: the effective number of draws is about a fifth; three sigmas.
  EXPECT_NEAR(found / possible, 0.75, 3.0 * std::sqrt(0.75 * 0.25 / (possible / 5.0)));
  EXPECT_NEAR(missed / runs, 3.0, 0.3);  // the frames' gaps at turns cut some runs
  EXPECT_NEAR(sporadic / frames, 0.2, 4.0 * std::sqrt(0.2 / frames));
  EXPECT_GT(places, 0.0);
  EXPECT_NEAR(sum / edges, 0.0, 4.0 / std::sqrt(edges));
  EXPECT_NEAR(std::sqrt(squares / edges), 1.0, 4.0 / std::sqrt(2.0 * edges));
}

TEST(Detector, ADistractorIsCalledWhatItIsTakenFor) {
  Scene scene = level_scene();
  scene.objects.push_back(ellipsoid("stone", {-5, -5}, {1, 1, 1}, false));
  scene.confusions = {{"boulder", "pbr", 1.0}};
  const Recording r = made(scene);
  std::size_t stones = 0;
  for (std::size_t i = 0; i < r.truth.detections.size(); ++i)
    if (r.truth.detections[i].object.value == 3) {
      ++stones;
      EXPECT_EQ(r.survey.detections[i].object_class, "pbr");
    }
  EXPECT_GT(stones, 10U);
  EXPECT_FALSE(r.truth.objects[2].sought);
}

TEST(Simulate, RefusesWhatCannotBeFlown) {
  const auto message = [](const Scene& scene) -> std::string {
    try {
      static_cast<void>(made(scene));
    } catch (const base::Error& error) {
      return error.record() + "|" + error.what();
    }
    return "";
  };
  Scene scene = level_scene();
  scene.flights[0].speed_m_s = -1.0;
  EXPECT_EQ(message(scene).rfind("flights[0].speed_m_s|", 0), 0U);
  scene = level_scene();
  scene.objects[0].position = Vec2(500, 0);
  EXPECT_NE(message(scene).find("does not stand on the ground"), std::string::npos);
  scene = level_scene();
  scene.flights[0].kind = FlightKind::orbit;
  scene.flights[0].about = "nobody";
  EXPECT_NE(message(scene).find("not in the scene"), std::string::npos);
  scene = level_scene();
  Scatter crowd;
  crowd.count = 10000;
  crowd.spacing_m = 5.0;
  crowd.area = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
  scene.objects[0].name.clear();
  scene.objects[0].position.reset();
  scene.objects[0].scatter = crowd;
  EXPECT_THAT(message(scene), testing::HasSubstr("no room"));
}

}  // namespace
