// Range scanner, contacts and the sight of a moving vehicle, against values worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/run_context.hpp"
#include "camera/projection.hpp"
#include "simulation/drive_rehearsal.hpp"

namespace cairn::simulation {
namespace {

using geometry::Ring;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kFloat_m = 1e-4;  // m: ranges are single precision, and so is the ray caster

// A level field with a wall of 4 m x 0.2 m across the way at east 5 and a cone at (3, 2); the aircraft hovers above.
Scene field() {
  Scene scene;
  scene.name = "field";
  scene.terrain.min = {-10, -10};
  scene.terrain.max = {20, 10};
  ObjectSpec wall;
  wall.object_class = "wall";
  wall.shape.kind = ShapeKind::box;
  wall.shape.size_m = {4.0, 0.2, 1.0};
  wall.shape.edge_m = 1.0;
  wall.position = Vec2(5.0, 0.0);
  ObjectSpec cone;
  cone.object_class = "cone";
  cone.shape.kind = ShapeKind::cone;
  cone.shape.size_m = {0.4, 0.4, 0.8};
  cone.position = Vec2(3.0, 2.0);
  scene.objects = {wall, cone};
  scene.cameras = {r200_camera()};
  scene.cameras[0].id = survey::CameraId(1);
  scene.mount.gamma_deg = 90.0;
  Flight hover;
  hover.kind = FlightKind::waypoints;
  hover.waypoints = {{0, 0, 12}, {1, 0, 12}};
  hover.rate_hz = 4.0;
  hover.heading_deg = 0.0;
  scene.flights = {hover};
  DriveSpec drive;
  drive.start = {0, 0};
  drive.goal = {8, 0};
  drive.area = {{-5, -5}, {15, -5}, {15, 5}, {-5, 5}};
  drive.limit_s = 10.0;
  drive.scanner.sigma_m = 0.0;
  drive.scanner.dropout_share = 0.0;
  drive.scanner.turn_s = 0.0;
  drive.scanner.step_deg = 1.0;
  drive.scanner.height_m = 0.4;
  scene.drive = drive;
  return scene;
}

struct Field {
  Scene scene = field();
  base::RunContext ctx;
  DriveRehearsal rehearsal{scene, ctx};
};

TEST(RangeScanner, MeetsWallConeAndNothingWhereTheyAre) {
  const Field f;
  base::Random random(1, "test", 0);
  const auto turn = f.rehearsal.scan(f.rehearsal.standing({0, 0}, 0.0), Vec2::Zero(), 0.0, 5, random);
  ASSERT_EQ(turn.ranges.size(), 271U);
  EXPECT_EQ(turn.time_ns, 5);
  const auto at = [&](int deg) { return static_cast<double>(turn.ranges.at(static_cast<std::size_t>(135 + deg))); };
  EXPECT_NEAR(at(0), 4.9, kFloat_m);
  EXPECT_NEAR(at(10), 4.9 / std::cos(base::deg_to_rad(10)), kFloat_m);
  EXPECT_TRUE(std::isinf(at(-60)));
  EXPECT_TRUE(std::isinf(at(90)));
  // The cone's axis stands at 33.7 deg and 3.606 m; at the scanner's height its radius is half of 0.2 m.
  double nearest = 1e9;
  for (int deg = 30; deg <= 37; ++deg) nearest = std::min(nearest, at(deg));
  EXPECT_NEAR(nearest, std::hypot(3.0, 2.0) - 0.1, 0.01);
}

TEST(RangeScanner, TurnsWithTheVehicleAndMarksWhatIsNoMeasurement) {
  Field f;
  base::Random random(1, "test", 0);
  auto turn = f.rehearsal.scan(f.rehearsal.standing({0, 0}, std::numbers::pi / 2), Vec2::Zero(), 0.0, 0, random);
  EXPECT_NEAR(static_cast<double>(turn.ranges.at(135 - 90)), 4.9, kFloat_m);
  f.scene.drive->scanner.range_min_m = 4.95;
  turn = f.rehearsal.scan(f.rehearsal.standing({0, 0}, 0.0), Vec2::Zero(), 0.0, 0, random);
  EXPECT_TRUE(std::isinf(turn.ranges.at(135)) && turn.ranges.at(135) < 0.0F);
  f.scene.drive->scanner.dropout_share = 1.0;
  turn = f.rehearsal.scan(f.rehearsal.standing({0, 0}, 0.0), Vec2::Zero(), 0.0, 0, random);
  EXPECT_TRUE(std::isnan(turn.ranges.at(135)));
}

TEST(RangeScanner, EachRayStartsWhereTheSensorIsThen) {
  Field f;
  f.scene.drive->scanner.turn_s = 0.027;
  base::Random random(1, "test", 0);
  const auto turn = f.rehearsal.scan(f.rehearsal.standing({0, 0}, 0.0), Vec2(10.0, 0.0), 0.0, 0, random);
  EXPECT_EQ(turn.time_increment_ns, 100'000);
  EXPECT_NEAR(static_cast<double>(turn.ranges.at(135)), 4.9 - 10.0 * 0.0135, kFloat_m);
}

TEST(VehicleContact, DistanceFromBodyToOutline) {
  const Field f;
  const auto& body = f.scene.drive->body;
  // Facing the wall's side at east 4.9.
  EXPECT_NEAR(f.rehearsal.contact().nearest({4.0, -1.0}, 0.0).distance_m, 0.9 - 0.5 * body.length_m, 1e-6);
  EXPECT_NEAR(f.rehearsal.contact().nearest({4.0, -1.0}, std::numbers::pi / 2).distance_m, 0.9 - 0.5 * body.width_m,
              1e-6);
  EXPECT_EQ(f.rehearsal.contact().nearest({5.0, 2.1}, 0.0).distance_m, 0.0);
  EXPECT_EQ(f.rehearsal.contact().nearest({3.3, 2.0}, 0.0).object, 1U);
}

TEST(VehicleContact, ConvexDistance) {
  const Ring a{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  EXPECT_DOUBLE_EQ(convex_distance(a, {{2, 0}, {3, 0}, {3, 1}, {2, 1}}), 1.0);
  EXPECT_DOUBLE_EQ(convex_distance(a, {{4, 5}, {5, 5}, {5, 6}}), 5.0);
  EXPECT_DOUBLE_EQ(convex_distance(a, {{0.2, 0.2}, {0.4, 0.2}, {0.4, 0.4}}), 0.0);
  EXPECT_TRUE(std::isinf(convex_distance(a, {})));
}

TEST(DriveRehearsal, VehicleIsSeenWhereItStands) {
  Field f;
  const auto pose = f.rehearsal.standing({1.0, 2.0}, 0.3);
  const auto sighting = f.rehearsal.sight(0, pose, 7);
  ASSERT_EQ(sighting.truth.size(), 1U);
  ASSERT_EQ(sighting.detection.size(), 1U);
  EXPECT_EQ(sighting.detection[0].object_class, "ugv");
  EXPECT_TRUE(sighting.truth[0].whole);
  EXPECT_GT(sighting.truth[0].visible_share, 0.9);
  const auto& camera = f.scene.cameras[0];
  const auto pixel = camera::project_world(camera, f.rehearsal.flown().exposures()[0].T_world_camera,
                                           pose.position + Vec3(0, 0, 0.25));
  ASSERT_TRUE(pixel);
  EXPECT_TRUE(sighting.truth[0].box.contains(*pixel));
  EXPECT_TRUE(f.rehearsal.sight(0, f.rehearsal.standing({14.0, 2.0}, 0.3), 7).truth.empty());
}

TEST(DriveRehearsal, FlightGoesOnUntilTheLimit) {
  const Field f;
  const auto& exposures = f.rehearsal.flown().exposures();
  EXPECT_NEAR(exposures.back().time_s, 10.0, 0.25 + 1e-9);
  EXPECT_LE(exposures.back().time_s, 10.0);
}

TEST(DriveRehearsal, MissesComeAtTheirRate) {
  Field f;
  f.scene.detector.miss_rate = 0.5;
  int seen = 0;
  for (std::size_t i = 0; i < 40; ++i)
    seen += static_cast<int>(f.rehearsal.sight(i, f.rehearsal.standing({0.5, 0}, 0.0), 3).detection.size());
  // Binomial of 40 draws of a half: 4 sigma are 13.
  EXPECT_NEAR(seen, 20, 13);
}

TEST(DriveSpec, StartInAnObjectIsRefused) {
  Scene scene = field();
  scene.drive->start = {4.9, 0.0};
  base::RunContext ctx;
  try {
    const DriveRehearsal rehearsal(scene, ctx);
    FAIL() << "accepted";
  } catch (const base::Error& error) {
    EXPECT_EQ(error.code(), base::ErrorCode::failed_precondition);
    EXPECT_EQ(error.record(), "drive.start");
  }
  scene.drive->start = {100.0, 0.0};
  EXPECT_THROW(validate(scene), base::Error);
  scene.drive.reset();
  EXPECT_THROW(DriveRehearsal(scene, ctx), base::Error);
}

}  // namespace
}  // namespace cairn::simulation
