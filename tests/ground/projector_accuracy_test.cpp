// Paper B's experiment of accuracy (B8), simulated: a cone of 380 x 380 x 700 mm at 0, 1 and 1.7 m, seen from 5 to 15 m
// by an aircraft with RTK. docs/accuracy.md has the table; --gtest_also_run_disabled_tests prints it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "ground/class_table.hpp"
#include "ground/projector.hpp"
#include "support/ground_views.hpp"

namespace cairn::ground {
namespace {

using geometry::Vec3;

constexpr double kWidth = 0.38, kHeight = 0.7;  // m; of the cone
// 1 sigma: RTK with its lever arm, a gimbal's attitude, a detector's edges, a terrain model.
constexpr double kPositionXy = 0.02, kPositionZ = 0.03, kAttitudeDeg = 0.3, kEdgePx = 1.5, kEdgeFraction = 0.02,
                 kTerrain = 0.03;

// Ground flat within about 1 m, as paper B's site: a slope of 3 % and waves.
double true_ground(double e, double n) {
  return 0.03 * e - 0.02 * n + 0.15 * std::sin(0.25 * e) * std::cos(0.2 * n);
}

struct Errors {
  std::vector<double> position, width;
  std::size_t rejected = 0;
  double chi2 = 0.0;  // mean of e^T C^-1 e
  [[nodiscard]] static double quantile(std::vector<double> values, double q) {
    std::sort(values.begin(), values.end());
    return values.at(static_cast<std::size_t>(q * static_cast<double>(values.size() - 1)));
  }
};

Errors simulate(const std::string& mode, double altitude, double raised, double lateral, int draws) {
  const auto camera = cairn::testing::board_camera();
  base::Random random(11, "projector_accuracy/" + std::to_string(altitude) + std::to_string(raised), 0);
  Errors errors;
  ProjectionOptions options;
  options.mode = mode;
  ObjectModel model = model_of_class("cone", {});
  model.base_above_ground_m = raised;
  for (int i = 0; i < draws; ++i) {
    // Anywhere, so that the ground differs; the plane of paper mode is the ground below the aircraft (its lidar).
    const Vec3 home(random.uniform(-40, 40), random.uniform(-40, 40), 0.0);
    const double below = true_ground(home.x(), home.y());
    const Vec3 eye(home.x(), home.y(), below + altitude);
    const double angle = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double distance = lateral * std::sqrt(random.uniform());
    Vec3 foot = home + distance * Vec3(std::cos(angle), std::sin(angle), 0.0);
    foot.z() = true_ground(foot.x(), foot.y()) + raised;
    // The gimbal holds the object within a metre of the axis.
    const auto truth =
        cairn::testing::frame_looking(eye, foot + Vec3(random.uniform(-0.7, 0.7), random.uniform(-0.7, 0.7), 0.0));
    const auto exact =
        cairn::testing::frustum_box(camera, truth.T_world_camera, foot, 0.5 * kWidth, 0.05 * kWidth, kHeight);
    const auto edge = [&](double side) { return std::hypot(kEdgePx, kEdgeFraction * side) * random.normal(); };
    const geometry::PixelBox box{exact.xmin + edge(exact.width()), exact.ymin + edge(exact.height()),
                                 exact.xmax + edge(exact.width()), exact.ymax + edge(exact.height())};
    auto frame = truth;
    frame.T_world_camera.translation +=
        Vec3(kPositionXy * random.normal(), kPositionXy * random.normal(), kPositionZ * random.normal());
    for (int a = 0; a < 3; ++a)
      frame.T_world_camera.rotation =
          geometry::axis_rotation(Vec3::Unit(a), kAttitudeDeg * std::numbers::pi / 180.0 * random.normal()) *
          frame.T_world_camera.rotation;
    frame.sigma_xy_m = kPositionXy;
    frame.sigma_z_m = kPositionZ;
    frame.sigma_rot_deg = kAttitudeDeg;
    const double terrain_error = kTerrain * random.normal();
    const GroundHeight terrain = [terrain_error](double e, double n) {
      return std::optional<double>(true_ground(e, n) + terrain_error);
    };
    options.ground_up_m = below;
    const auto projection = project_box(box, frame, camera, terrain, options, model);
    if (std::holds_alternative<base::Reject>(projection)) {
      ++errors.rejected;
      continue;
    }
    const auto& p = std::get<Projected>(projection);
    const geometry::Vec2 d = (p.position - foot).head<2>();
    errors.position.push_back(d.norm());
    errors.width.push_back(std::abs(p.width_m - kWidth));
    const auto& c = p.covariance;
    errors.chi2 += (c(1, 1) * d.x() * d.x() - 2.0 * c(0, 1) * d.x() * d.y() + c(0, 0) * d.y() * d.y()) /
                   (c(0, 0) * c(1, 1) - c(0, 1) * c(0, 1)) / draws;
  }
  return errors;
}

double lateral_of(double raised) {
  return raised > 0.0 ? 5.0 : 2.5;  // m; paper B's offsets, level and elevated
}

// The limits: median 0.15 m and 95 % 0.5 m in position, 0.1 m in size.
TEST(ProjectorAccuracy, ReachesItsFigures) {
  constexpr int kDraws = 300;
  for (const double altitude : {5.0, 10.0, 15.0})
    for (const double raised : {0.0, 1.0, 1.7}) {
      const auto e = simulate("robust", altitude, raised, lateral_of(raised), kDraws);
      EXPECT_EQ(e.rejected, 0U);
      EXPECT_LE(Errors::quantile(e.position, 0.5), 0.15) << altitude << " " << raised;
      EXPECT_LE(Errors::quantile(e.position, 0.95), 0.5) << altitude << " " << raised;
      EXPECT_LE(Errors::quantile(e.width, 0.95), 0.1) << altitude << " " << raised;
      // Mean of chi-squared with two degrees of freedom: 2. Its sampling error is 0.12; the options' edge noise is
      // larger than the draws'.
      EXPECT_GT(e.chi2, 1.0) << altitude << " " << raised;
      EXPECT_LT(e.chi2, 2.6) << altitude << " " << raised;
      // The letter of the paper, on the same draws, errs by what section 8 of its reading says.
      const auto letter = simulate("paper", altitude, raised, lateral_of(raised), kDraws);
      if (raised > 0.0) {
        EXPECT_GT(Errors::quantile(letter.position, 0.5), Errors::quantile(e.position, 0.5));
      }
    }
}

TEST(ProjectorAccuracy, DISABLED_PrintsTheTable) {
  std::printf("| mode | altitude | raised | median | 95 %% | largest | size median | size 95 %% | chi2 |\n");
  for (const std::string mode : {"paper", "robust"})
    for (const double altitude : {5.0, 10.0, 15.0})
      for (const double raised : {0.0, 1.0, 1.7}) {
        const auto e = simulate(mode, altitude, raised, lateral_of(raised), 2000);
        std::printf("| %s | %g | %g | %.2f | %.2f | %.2f | %.3f | %.3f | %.2f | rejected %zu\n", mode.c_str(), altitude,
                    raised, Errors::quantile(e.position, 0.5), Errors::quantile(e.position, 0.95),
                    Errors::quantile(e.position, 1.0), Errors::quantile(e.width, 0.5), Errors::quantile(e.width, 0.95),
                    e.chi2, e.rejected);
      }
}

}  // namespace
}  // namespace cairn::ground
