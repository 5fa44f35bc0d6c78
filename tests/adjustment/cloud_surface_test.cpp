#include "adjustment/cloud_surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "adjustment/evidence_cloud.hpp"
#include "support/simulated_survey.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Vec2;
using geometry::Vec3;

// Brightness of the simulated ground, 0..255, with detail down to a metre.
double brightness(double east, double north) {
  return 120.0 + 50.0 * std::sin(1.7 * east + 0.4 * north) + 40.0 * std::cos(1.1 * north - 0.6 * east) +
         20.0 * std::sin(0.31 * east * std::sin(0.2 * north));
}

geometry::PointCloud cloud_of_ground(const Vec3& offset, std::uint16_t colour_scale = 1) {
  geometry::PointCloud cloud;
  base::Random random(5, "cloud", 0);
  for (int i = 0; i < 60000; ++i) {
    const double east = random.uniform(-15.0, 55.0), north = random.uniform(-15.0, 45.0);
    cloud.positions.push_back(Vec3(east, north, testing::bumpy_ground(east, north)) + offset);
    const auto grey = static_cast<std::uint16_t>(std::lround(brightness(east, north)) * colour_scale);
    cloud.colours.push_back({grey, grey, grey});
  }
  return cloud;
}

// What a camera sees of the same ground; rays are followed down to the surface by fixed-point steps.
geometry::GreyImage photograph(const survey::Survey& survey, const survey::Frame& frame) {
  const auto camera = camera::scaled(*survey.camera(frame.camera), 0.25);
  geometry::GreyImage image{static_cast<std::size_t>(camera.width_px), static_cast<std::size_t>(camera.height_px), {}};
  for (std::size_t r = 0; r < image.height_px; ++r)
    for (std::size_t c = 0; c < image.width_px; ++c) {
      const auto ray =
          camera::pixel_ray(camera, frame.T_world_camera, {static_cast<double>(c) + 0.5, static_cast<double>(r) + 0.5});
      Vec3 p = ray->origin;
      double up = 3.0;
      for (int step = 0; step < 8; ++step) {
        p = ray->origin + ray->direction * ((up - ray->origin.z()) / ray->direction.z());
        up = testing::bumpy_ground(p.x(), p.y());
      }
      image.values.push_back(static_cast<std::uint8_t>(std::lround(brightness(p.x(), p.y()))));
    }
  return image;
}

TEST(CloudSurface, HeightsAreThoseOfTheGround) {
  const auto surface = cloud_surface(cloud_of_ground(Vec3::Zero()));
  EXPECT_TRUE(surface.coloured);
  EXPECT_NEAR(surface.point_spacing_m, std::sqrt(70.0 * 60.0 / 60000.0), 0.03);
  constexpr double kCellM = 0.1;  // slope of the ground times half a cell
  for (const double east : {0.0, 13.3, 40.2})
    for (const double north : {-3.0, 20.7}) {
      const auto height = surface.height_at({east, north});
      ASSERT_TRUE(height.has_value());
      EXPECT_NEAR(*height, testing::bumpy_ground(east, north), kCellM);
    }
  EXPECT_FALSE(surface.height_at({200.0, 0.0}).has_value());
}

TEST(CloudSurface, EmptyNonFiniteAndHugeCloudsAreHarmless) {
  EXPECT_EQ(cloud_surface({}).up_m.values.size(), 0U);
  geometry::PointCloud odd;
  odd.positions = {{0, 0, 0}, {std::numeric_limits<double>::quiet_NaN(), 0, 0}, {1e7, 1e7, 0}};
  const auto surface = cloud_surface(odd, 0.01, 1, 10000);
  EXPECT_LE(surface.up_m.values.size(), 10000U);
  EXPECT_FALSE(surface.coloured);
}

TEST(CloudSurface, SixteenBitColoursMeanTheSame) {
  const auto eight = cloud_surface(cloud_of_ground(Vec3::Zero(), 1));
  const auto sixteen = cloud_surface(cloud_of_ground(Vec3::Zero(), 257));
  ASSERT_EQ(eight.brightness.values.size(), sixteen.brightness.values.size());
  for (std::size_t i = 0; i < eight.brightness.values.size(); i += 97)
    if (!std::isnan(eight.brightness.values[i])) {
      EXPECT_NEAR(eight.brightness.values[i], sixteen.brightness.values[i], 0.01F);
    }
}

TEST(CloudEvidence, MeasuresAKnownOffsetWithAndWithoutTiePoints) {
  auto survey = testing::simulated_survey();
  std::vector<geometry::GreyImage> images;
  for (const auto& frame : survey.frames) images.push_back(photograph(survey, frame));
  std::vector<FrameImage> frame_images;
  for (std::size_t i = 0; i < images.size(); ++i) frame_images.push_back({survey.frames[i].id, &images[i]});
  const Vec3 offset(0.6, -0.4, 0.9);
  const auto surface = cloud_surface(cloud_of_ground(offset));
  constexpr double kM = 0.08;  // a fifth of a pixel of the simulated photographs on the ground is 0.04 m
  for (const bool ties : {true, false}) {
    if (!ties) survey.ties.clear();
    const auto evidence = cloud_evidence(survey, frame_images, surface);
    ASSERT_TRUE(evidence.horizontal_m && evidence.vertical_m);
    EXPECT_NEAR(evidence.horizontal_m->x(), offset.x(), kM);
    EXPECT_NEAR(evidence.horizontal_m->y(), offset.y(), kM);
    EXPECT_NEAR(*evidence.vertical_m, offset.z(), ties ? kM : 4.0 * kM);
    EXPECT_EQ(evidence.vertical_by, ties ? "tie_points" : "parallax");
    EXPECT_LT(evidence.horizontal_scatter_m.norm(), 2.0 * kM);
  }
}

TEST(CloudEvidence, SaysNothingWithoutColoursImagesOrTies) {
  auto survey = testing::simulated_survey();
  survey.ties.clear();
  auto cloud = cloud_of_ground(Vec3::Zero());
  EXPECT_FALSE(cloud_evidence(survey, {}, cloud_surface(cloud)).horizontal_m.has_value());
  cloud.colours.clear();
  const auto evidence = cloud_evidence(survey, {}, cloud_surface(cloud));
  EXPECT_FALSE(evidence.horizontal_m.has_value());
  EXPECT_FALSE(evidence.vertical_m.has_value());
}

}  // namespace
}  // namespace cairn::adjustment
