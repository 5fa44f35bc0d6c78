#include "ground/obstacles.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "camera/projection.hpp"
#include "support/nadir_survey.hpp"

namespace cairn::ground {
namespace {

using geometry::Vec3;
using survey::ObstacleKind;
using survey::Target;
using survey::TargetState;

// Outline of an upright cylinder in a frame, as a detector's box.
geometry::PixelBox outline(const survey::Survey& s, const survey::Frame& frame, const Vec3& foot, double diameter,
                           double height) {
  geometry::PixelBox box{1e9, 1e9, -1e9, -1e9};
  for (int i = 0; i < 360; ++i)
    for (const double h : {0.0, height}) {
      const double a = 2.0 * std::numbers::pi * i / 360.0;
      const auto p = camera::project_world(s.manifest.cameras[0], frame.T_world_camera,
                                           foot + Vec3(0.5 * diameter * std::cos(a), 0.5 * diameter * std::sin(a), h));
      box = {std::min(box.xmin, p->x()), std::min(box.ymin, p->y()), std::max(box.xmax, p->x()),
             std::max(box.ymax, p->y())};
    }
  return box;
}

struct Scene {
  testing::NadirSurvey base{5, 5.0};
  std::vector<Target> targets;

  Target& cylinder(const Vec3& foot, double diameter, double height, const std::string& object_class = "boulder") {
    Target t;
    t.id = survey::TargetId(static_cast<std::int64_t>(targets.size()) + 1);
    t.object_class = object_class;
    t.state = TargetState::converged;
    t.centre = foot + Vec3(0, 0, 0.5 * height);
    t.covariance = 0.01 * geometry::Mat3::Identity();
    t.mean_score = 0.8;
    for (const auto& frame : base.survey.frames) {
      const auto box = outline(base.survey, frame, foot, diameter, height);
      if (box.xmin < 10 || box.xmax > 990) continue;
      t.detections.push_back(base.box(frame.id, box, object_class).id);
    }
    targets.push_back(t);
    return targets.back();
  }
  [[nodiscard]] ObstacleResult run(const ObstacleOptions& options = {}, const GroundHeight& ground = level()) const {
    base::RunContext ctx;
    return make_obstacles(targets, base.survey, ground, options, ctx);
  }
  static GroundHeight level() {
    return [](double, double) { return std::optional<double>(0.0); };
  }
};

TEST(Obstacles, MeasuresAnUprightCylinder) {
  Scene scene;
  scene.cylinder({8, 3, 0}, 1.2, 0.9);
  const auto result = scene.run();
  ASSERT_EQ(result.obstacles.size(), 1U);
  const auto& o = result.obstacles[0];
  EXPECT_NEAR(o.height_m, 0.9, 1e-9);
  EXPECT_NEAR(o.width_m, 1.2, 0.03);  // m; first order in size over distance
  EXPECT_EQ(o.position, Vec3(8, 3, 0));
  EXPECT_EQ(o.kind, ObstacleKind::obstacle);
  EXPECT_EQ(o.observations, 5U);
  EXPECT_DOUBLE_EQ(o.covariance(0, 0), 0.01);
  EXPECT_DOUBLE_EQ(o.score, 0.8);
}

TEST(Obstacles, MeasuresFromAnObliqueView) {
  Scene scene;
  // Look 45 deg down towards north from 30 m south of the object.
  for (auto& frame : scene.base.survey.frames) {
    const double c = std::sqrt(0.5);
    frame.T_world_camera.rotation << 1, 0, 0, 0, -c, c, 0, -c, -c;
    frame.T_world_camera.translation.y() = -30.0;
    frame.T_world_camera.translation.z() = 30.0;
  }
  scene.cylinder({9, 0, 0}, 1.0, 2.0);
  const auto result = scene.run();
  ASSERT_EQ(result.obstacles.size(), 1U);
  EXPECT_NEAR(result.obstacles[0].width_m, 1.0, 0.05);
  EXPECT_NEAR(result.obstacles[0].height_m, 2.0, 1e-9);
}

TEST(Obstacles, KindsFollowTheTables) {
  Scene scene;
  for (const auto* name : {"Cone", "bush", "tree", "UGV", "meteorite"}) scene.cylinder({8, 0, 0}, 1.0, 1.0, name);
  base::RunContext ctx;
  const auto result = make_obstacles(scene.targets, scene.base.survey, Scene::level(), {}, ctx);
  std::vector<ObstacleKind> kinds;
  for (const auto& o : result.obstacles) kinds.push_back(o.kind);
  EXPECT_THAT(kinds, ::testing::ElementsAre(ObstacleKind::obstacle, ObstacleKind::obstacle, ObstacleKind::ignored,
                                            ObstacleKind::vehicle, ObstacleKind::obstacle));
  EXPECT_THAT(result.unknown_classes, ::testing::ElementsAre("meteorite"));
  ASSERT_EQ(ctx.warnings().size(), 1U);
  EXPECT_THAT(ctx.warnings()[0], ::testing::HasSubstr("meteorite"));
}

TEST(Obstacles, LeavesOutWhatIsNotLocated) {
  Scene scene;
  scene.cylinder({8, 0, 0}, 1.0, 1.0).state = TargetState::deregistered;
  scene.cylinder({8, 0, 0}, 1.0, 1.0).state = TargetState::generated;
  scene.cylinder({8, 0, 0}, 1.0, 1.0).state = TargetState::converging;
  scene.cylinder({8, 0, 0}, 1.0, 1.0).centre.x() = std::nan("");
  const auto result = scene.run();
  EXPECT_EQ(result.obstacles.size(), 1U);
  ASSERT_EQ(result.rejects.size(), 3U);
  EXPECT_EQ(result.rejects[0].reason, "target_deregistered");
  EXPECT_EQ(result.rejects[1].reason, "not_located");
  EXPECT_EQ(result.rejects[2].reason, "not_located");
  ObstacleOptions strict;
  strict.least_state = "converged";
  EXPECT_TRUE(scene.run(strict).obstacles.empty());
}

TEST(Obstacles, WithoutGroundTheFootIsBelowTheCentre) {
  Scene scene;
  scene.cylinder({8, 0, 0}, 1.0, 0.5);
  const auto none = scene.run({}, nullptr);
  ASSERT_EQ(none.obstacles.size(), 1U);
  EXPECT_EQ(none.without_ground, 1U);
  EXPECT_NEAR(none.obstacles[0].position.z(), 0.0, 0.02);
  EXPECT_NEAR(none.obstacles[0].width_m, 1.0, 0.03);
  const auto unknown = scene.run({}, [](double, double) { return std::optional<double>(std::nan("")); });
  EXPECT_EQ(unknown.without_ground, 1U);
  EXPECT_TRUE(unknown.obstacles[0].position.allFinite());
}

TEST(Obstacles, WidthFromTheCylinderWhereNoBoxIsWhole) {
  Scene scene;
  auto& target = scene.cylinder({8, 0, 0}, 1.0, 1.0);
  target.detections.clear();
  EXPECT_EQ(scene.run().rejects.at(0).reason, "no_size");
  target.bcylinder = geometry::VerticalCylinder{{8, 0}, 0.0, 1.0, 0.7};
  EXPECT_DOUBLE_EQ(scene.run().obstacles.at(0).width_m, 1.4);
}

TEST(Obstacles, ASunkenObjectKeepsTheLeastHeight) {
  Scene scene;
  scene.cylinder({8, 0, 0}, 1.0, 0.2);
  const auto result = scene.run({}, [](double, double) { return std::optional<double>(0.5); });
  EXPECT_DOUBLE_EQ(result.obstacles.at(0).height_m, 0.1);
}

}  // namespace
}  // namespace cairn::ground
