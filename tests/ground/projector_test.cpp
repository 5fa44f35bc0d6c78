#include "ground/projector.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/random.hpp"
#include "ground/body_outline.hpp"
#include "support/ground_views.hpp"

namespace cairn::ground {
namespace {

using cairn::testing::board_camera;
using cairn::testing::frame_looking;
using cairn::testing::frustum_box;
using geometry::PixelBox;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kOracle = 1e-9;  // relative, of the paper's closed forms: rounding alone
constexpr double kExact = 2e-4;   // m; outline of 24 points with a parabola against 3600 points

ProjectionOptions paper(double up = 0.0) {
  ProjectionOptions options;
  options.mode = "paper";
  options.ground_up_m = up;
  return options;
}

Projected projected(const Projection& projection) {
  if (const auto* reject = std::get_if<base::Reject>(&projection)) {
    ADD_FAILURE() << reject->reason << ": " << reject->message;
    return {};
  }
  return std::get<Projected>(projection);
}
std::string reason(const Projection& projection) {
  const auto* reject = std::get_if<base::Reject>(&projection);
  return reject == nullptr ? "" : reject->reason;
}

// Section 8 of the reading of the papers: an object h above the plane is scaled by H/(H-h) and shifted by r h/(H-h).
TEST(PaperProjector, RaisedObjectsAreScaledAndShiftedByTheClosedForm) {
  const auto camera = board_camera();
  for (const double up : {0.0, 137.25})
    for (const double height : {5.0, 10.0, 15.0})
      for (const double raised : {0.0, 1.0, 1.7})
        for (const double r : {0.0, 1.0, 2.5}) {
          const Vec3 eye(100.0, -40.0, up + height), truth = Vec3(100.0, -40.0 + r, up + raised);
          // Level, in the vertical plane of camera and object: left and right at the same distance.
          const auto frame = frame_looking(eye, Vec3(100.0, -40.0 + 0.3, up));
          const double width = 0.38;
          const auto& T = frame.T_world_camera;
          const auto centre = camera::project_world(camera, T, truth);
          const auto left = camera::project_world(camera, T, truth - Vec3(0.5 * width, 0, 0)),
                     right = camera::project_world(camera, T, truth + Vec3(0.5 * width, 0, 0));
          ASSERT_TRUE(centre && left && right);
          const PixelBox box{left->x(), centre->y() - 10.0, right->x(), centre->y() + 10.0};
          const auto p = projected(project_box(box, frame, camera, {}, paper(up)));
          EXPECT_NEAR(p.width_m, width * height / (height - raised), kOracle * width);
          EXPECT_NEAR(p.position.y() - truth.y(), r * raised / (height - raised), kOracle * height);
          EXPECT_NEAR(p.position.x(), truth.x(), kOracle * height);
          EXPECT_NEAR(p.position.z(), up, kOracle * height);
        }
}

TEST(PaperProjector, TableOfScales) {
  const auto camera = board_camera();
  const std::array<std::array<double, 3>, 6> rows{
      {{5, 1, 1.25}, {5, 1.7, 1.515}, {10, 1, 1.111}, {10, 1.7, 1.205}, {15, 1, 1.071}, {15, 1.7, 1.128}}};
  constexpr double kPrinted = 5e-4;  // three decimals
  for (const auto& [height, raised, scale] : rows) {
    const auto frame = frame_looking(Vec3(0, 0, height), Vec3::Zero());
    const double half = 0.5 * camera.fx_px / (height - raised);
    const PixelBox box{640 - half, 360 - half, 640 + half, 360 + half};
    EXPECT_NEAR(projected(project_box(box, frame, camera, {}, paper())).width_m, scale, kPrinted);
  }
}

// Any attitude: (B.1) puts a point of the plane back where it is.
TEST(PaperProjector, ReturnsPointsOfThePlane) {
  const auto camera = board_camera();
  base::Random random(7, "projector", 0);
  for (int i = 0; i < 200; ++i) {
    const Vec3 truth(random.uniform(-20, 20), random.uniform(-20, 20), 3.0);
    const auto frame = frame_looking(Vec3(random.uniform(-5, 5), random.uniform(-5, 5), 3.0 + random.uniform(5, 15)),
                                     truth + Vec3(random.uniform(-2, 2), random.uniform(-2, 2), 0.0));
    const auto p = camera::project_world(camera, frame.T_world_camera, truth);
    ASSERT_TRUE(p);
    const auto result =
        projected(project_box({p->x() - 5, p->y() - 8, p->x() + 5, p->y() + 8}, frame, camera, {}, paper(3.0)));
    EXPECT_LT((result.position - truth).norm(), 1e-8);  // m; rays of 40 m at 5 deg to the plane lose digits
  }
}

TEST(Projector, RejectsWhatMeetsNoGround) {
  const auto camera = board_camera();
  const auto level = frame_looking(Vec3(0, 0, 10), Vec3(0, 100, 10));  // horizon in the middle row
  const PixelBox sky{600, 100, 640, 150}, far{600, 355, 640, 370}, near{600, 560, 640, 600};
  for (const auto& options : {paper(), ProjectionOptions{}}) {
    EXPECT_EQ(reason(project_box(sky, level, camera, {}, options)), "above_horizon");
    EXPECT_EQ(reason(project_box(near, level, camera, {}, options)), "");
    EXPECT_NE(reason(project_box(far, level, camera, {}, options)), "");
    EXPECT_EQ(reason(project_box({600, 500, 600, 520}, level, camera, {}, options)), "bad_box");
    EXPECT_EQ(reason(project_box({600, std::nan(""), 640, 520}, level, camera, {}, options)), "bad_box");
    auto lost = level;
    lost.T_world_camera.translation.x() = std::numeric_limits<double>::infinity();
    EXPECT_EQ(reason(project_box(near, lost, camera, {}, options)), "bad_pose");
  }
  // A camera below the plane sees none of it from above.
  EXPECT_EQ(reason(project_box(near, level, camera, {}, paper(20.0))), "above_horizon");
}

struct Case {
  Vec3 foot;
  Vec3 eye;
  double width, height;
};
const std::vector<Case> kCases{{{0, 12, 0}, {0, 0, 10}, 0.4, 0.7},
                               {{3, 8, 0}, {0, 0, 14}, 1.5, 1.0},
                               {{-4, 2, 0}, {0, 0, 9}, 0.9, 0.5},
                               {{2, 1.5, 0}, {0, 0, 12}, 0.38, 0.7}};

TEST(RobustProjector, FindsTheUprightBodyThatFillsTheBox) {
  const auto camera = board_camera();
  for (const auto& c : kCases)
    for (const Shape shape : {Shape::cylinder, Shape::cone}) {
      const auto frame = frame_looking(c.eye, c.foot + Vec3(0.5, -0.4, 0));
      const double top = shape == Shape::cone ? 0.1 : 1.0;
      const auto box = frustum_box(camera, frame.T_world_camera, c.foot, 0.5 * c.width, top * 0.5 * c.width, c.height);
      ObjectModel model;
      model.shape = shape;
      model.height_by_width = false;
      model.height = c.height;
      const auto p = projected(project_box(box, frame, camera, {}, {}, model));
      EXPECT_LT((p.position - c.foot).norm(), 5 * kExact);
      EXPECT_NEAR(p.width_m, c.width, 5 * kExact);
      EXPECT_NEAR(p.height_m, c.height, 5 * kExact);
      EXPECT_GT(p.sigma_width_m, 0.0);
      EXPECT_FALSE(p.on_terrain);
    }
}

// The height shows in an oblique view: a wrong prior is overruled.
TEST(RobustProjector, MeasuresTheHeightInObliqueViews) {
  const auto camera = board_camera();
  const Vec3 foot(0, 14, 0);
  const auto frame = frame_looking(Vec3(0, 0, 8), foot);
  const auto box = frustum_box(camera, frame.T_world_camera, foot, 0.5, 0.5, 1.6);
  ObjectModel model;
  model.height_by_width = false;
  model.height = 0.8;
  model.sigma_log_height = 0.6;
  const auto p = projected(project_box(box, frame, camera, {}, {}, model));
  EXPECT_NEAR(p.height_m, 1.6, 0.1);  // m; the prior pulls a little
  EXPECT_LT(std::abs(p.height_m - 1.6), 3.0 * p.sigma_height_m);
  EXPECT_NEAR(p.position.y(), 14.0, 0.1);
}

TEST(RobustProjector, StandsObjectsOnTheTerrain) {
  const auto camera = board_camera();
  const GroundHeight slope = [](double e, double n) { return std::optional<double>(2.0 + 0.1 * e - 0.15 * n); };
  const Vec3 foot(3, 9, 2.0 + 0.3 - 1.35);
  const auto frame = frame_looking(Vec3(0, 0, 12), foot);
  const auto box = frustum_box(camera, frame.T_world_camera, foot, 0.5, 0.5, 0.8);
  ObjectModel model;
  model.height_by_width = false;
  model.height = 0.8;
  const auto p = projected(project_box(box, frame, camera, slope, {}, model));
  EXPECT_LT((p.position - foot).norm(), 5 * kExact);
  EXPECT_TRUE(p.on_terrain);
  // The same with the plane of paper B at the mean height is off by more than a metre.
  ProjectionOptions level;
  level.ground_up_m = 2.0;
  EXPECT_GT((projected(project_box(box, frame, camera, {}, level, model)).position - foot).norm(), 0.9);
}

TEST(RobustProjector, KnowsObjectsOnATable) {
  const auto camera = board_camera();
  const Vec3 foot(1.5, 2.0, 1.7);
  const auto frame = frame_looking(Vec3(0, 0, 5), Vec3(0.5, 0.5, 0));
  const auto box = frustum_box(camera, frame.T_world_camera, foot, 0.19, 0.019, 0.7);
  ObjectModel model{Shape::cone, false, 0.7, 0.3, 1.7, false};
  EXPECT_LT((projected(project_box(box, frame, camera, {}, {}, model)).position - foot).norm(), 5 * kExact);
}

TEST(RobustProjector, UsesWhatTheBorderLeaves) {
  const auto camera = board_camera();
  const Vec3 foot(0, 10, 0);
  const auto frame = frame_looking(Vec3(0, 0, 10), foot);
  auto box = frustum_box(camera, frame.T_world_camera, foot, 0.5, 0.5, 0.7);
  auto shifted = camera;
  shifted.cx_px -= box.xmin + 10.0;  // the object's left 10 px leave the image
  auto cut = frustum_box(shifted, frame.T_world_camera, foot, 0.5, 0.5, 0.7);
  ASSERT_LT(cut.xmin, 0.0);
  cut.xmin = 0.0;
  ObjectModel model;
  model.height_by_width = false;
  model.height = 0.7;
  model.sigma_log_height = 0.1;
  const auto p = projected(project_box(cut, frame, shifted, {}, {}, model));
  EXPECT_LT((p.position - foot).norm(), 0.02);  // m
  cut.ymin = 0.0;
  EXPECT_EQ(reason(project_box(cut, frame, shifted, {}, {}, model)), "cut_by_border");
}

// The covariance is what noise does: Monte Carlo over box, pose and ground.
TEST(RobustProjector, CovarianceAgreesWithDraws) {
  const auto camera = board_camera();
  const Vec3 foot(2, 10, 0);
  const auto truth = frame_looking(Vec3(0, 0, 10), foot + Vec3(0.5, 0, 0));
  const auto box = frustum_box(camera, truth.T_world_camera, foot, 0.4, 0.4, 0.8);
  ObjectModel model;
  model.height_by_width = false;
  model.height = 0.8;
  model.sigma_log_height = 0.3;
  ProjectionOptions options;
  options.shape_noise = 0.0;
  const auto p = projected(project_box(box, truth, camera, {}, options, model));
  base::Random random(3, "projector", 1);
  constexpr int kDraws = 600;
  geometry::Mat2 scatter = geometry::Mat2::Zero();
  double width2 = 0.0;
  const double across = std::hypot(options.box_noise_px, options.box_noise_fraction * box.width()),
               down = std::hypot(options.box_noise_px, options.box_noise_fraction * box.height());
  for (int i = 0; i < kDraws; ++i) {
    auto frame = truth;
    const double xy = options.pose_noise_xy_m, z = options.pose_noise_z_m,
                 rot = options.pose_noise_rot_deg * std::numbers::pi / 180.0;
    frame.T_world_camera.translation += Vec3(xy * random.normal(), xy * random.normal(), z * random.normal());
    for (int a = 0; a < 3; ++a)
      frame.T_world_camera.rotation =
          geometry::axis_rotation(Vec3::Unit(a), rot * random.normal()) * frame.T_world_camera.rotation;
    const PixelBox noisy{box.xmin + across * random.normal(), box.ymin + down * random.normal(),
                         box.xmax + across * random.normal(), box.ymax + down * random.normal()};
    // The prior is information like any other: the truth is drawn from it by moving its mean.
    ObjectModel drawn = model;
    drawn.height *= std::exp(model.sigma_log_height * random.normal());
    ProjectionOptions here = options;
    here.ground_up_m = options.plane_noise_m * random.normal();
    const auto q = projected(project_box(noisy, frame, camera, {}, here, drawn));
    const Vec2 d = (q.position - foot).head<2>();
    scatter += d * d.transpose() / kDraws;
    width2 += (q.width_m - 0.8) * (q.width_m - 0.8) / kDraws;
  }
  constexpr double kSampling = 0.15;  // relative, of a standard deviation from 600 draws, and first order
  for (int a = 0; a < 2; ++a)
    EXPECT_NEAR(std::sqrt(scatter(a, a)), std::sqrt(p.covariance(a, a)), kSampling * std::sqrt(p.covariance(a, a)));
  EXPECT_NEAR(std::sqrt(width2), p.sigma_width_m, kSampling * p.sigma_width_m);
}

TEST(ClassTable, ReadsItsEntries) {
  const ClassTable table;
  EXPECT_EQ(kind_of_class("Cone", table), survey::ObstacleKind::obstacle);
  EXPECT_EQ(kind_of_class("TREE", table), survey::ObstacleKind::ignored);
  EXPECT_EQ(kind_of_class("ugv", table), survey::ObstacleKind::vehicle);
  EXPECT_FALSE(kind_of_class("meteorite", table));
  EXPECT_FALSE(kind_of_class("con", table));
  const auto cone = model_of_class("cone", table);
  EXPECT_EQ(cone.shape, Shape::cone);
  EXPECT_FALSE(cone.height_by_width);
  EXPECT_DOUBLE_EQ(cone.height, 0.7);
  EXPECT_TRUE(model_of_class("boulder", table).height_by_width);
  EXPECT_TRUE(model_of_class("UGV", table).vehicle);
  EXPECT_DOUBLE_EQ(model_of_class("meteorite", table).height, 0.7);
  for (const auto* bad : {"cone:cube:1m:1", "cone:cone:1:1", "cone:cone:-1m:1", "cone:cone:1m", "cone:cone:1m:nan"}) {
    ClassTable wrong;
    wrong.class_shapes = bad;
    EXPECT_THROW(static_cast<void>(model_of_class("cone", wrong)), base::Error) << bad;
  }
}

}  // namespace
}  // namespace cairn::ground
