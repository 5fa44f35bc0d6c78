#include "simulation/render.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "camera/projection.hpp"
#include "simulation/shape.hpp"
#include "support/meshes.hpp"

namespace cairn::simulation {
namespace {

using geometry::Vec2;
using geometry::Vec3;

RenderBody body(geometry::TriangleMesh mesh, SurfacePart part, std::int64_t object, const char* material = "gravel") {
  RenderBody b;
  b.mesh = std::move(mesh);
  b.material = material_named(material, 5).value();
  b.part = part;
  b.object = object;
  return b;
}

// Ball of radius 1 m, 1.5 m over level ground, object 7; a box beside it, object 3, on a pedestal of object 3.
std::vector<RenderBody> bodies() {
  std::vector<RenderBody> all;
  all.push_back(body(testing::slab(-12.0, -12.0, 12.0, 12.0, 0.0, 24), SurfacePart::terrain, -1));
  all.push_back(body(testing::sphere({0.0, 0.0, 1.5}, 1.0, 48), SurfacePart::rock, 7, "granite"));
  all.push_back(body(testing::box({3.0, -0.5, 0.5}, {4.0, 0.5, 1.5}), SurfacePart::rock, 3, "granite"));
  all.push_back(body(testing::box({2.8, -0.7, -0.2}, {4.2, 0.7, 0.5}), SurfacePart::pedestal, 3, "granite"));
  return all;
}

survey::Camera camera() {
  survey::Camera c;
  c.model = survey::CameraModel::brown;
  c.width_px = 160;
  c.height_px = 120;
  c.fx_px = c.fy_px = 130.0;
  c.cx_px = 80.0;
  c.cy_px = 60.0;
  c.k1 = -0.08;
  c.k2 = 0.01;
  c.p1 = 0.001;
  return c;
}

// Camera at height z looking down, image up = north.
geometry::RigidTransform from_above(const Vec3& eye) {
  geometry::RigidTransform pose;
  pose.rotation << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  pose.translation = eye;
  return pose;
}

Lighting light() {
  Lighting l;
  l.openness_rays = 8;
  return l;
}

RenderOptions plain() {
  RenderOptions options;
  options.samples = 1;
  options.image_noise = 0.0;
  return options;
}

TEST(Render, DepthAndMaskAreThoseOfTheSurfaces) {
  const RenderScene scene(bodies(), light());
  const auto pose = from_above({0.4, 0.3, 8.0});
  const auto frame = render(scene, camera(), pose, plain());
  ASSERT_EQ(frame.depth_m.size(), 160U * 120U);
  ASSERT_EQ(frame.rgb.size(), 3U * 160U * 120U);
  std::size_t ball = 0, box = 0;
  for (std::size_t row = 0; row < 120; ++row)
    for (std::size_t column = 0; column < 160; ++column) {
      const std::size_t i = row * 160 + column;
      const Vec2 pixel(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
      const auto ray = camera::pixel_ray(camera(), pose, pixel);
      ASSERT_TRUE(ray);
      // Where the depth says the surface is, seen from the pixel's own ray.
      const double along = static_cast<double>(frame.depth_m[i]) / -ray->direction.z();
      const Vec3 p = ray->origin + along * ray->direction;
      if (frame.instance[i] == 8) {
        ++ball;
        // The ball's facets lie inside it by less than r (pi / 96)^2.
        EXPECT_NEAR((p - Vec3(0.0, 0.0, 1.5)).norm(), 1.0, 2e-3);
      } else if (frame.instance[i] == 4) {
        ++box;
        EXPECT_TRUE(p.z() > 0.5 - 1e-3 && p.z() < 1.5 + 1e-3) << p.transpose();
      } else {
        ASSERT_EQ(frame.instance[i], 0);  // ground or pedestal
        EXPECT_TRUE(std::abs(p.z()) < 1e-3 || (p.z() < 0.5 + 1e-3 && p.x() > 2.7)) << p.transpose();
      }
    }
  EXPECT_GT(ball, 900U);
  EXPECT_GT(box, 200U);
}

TEST(Render, BeyondTheScenesEdgeNothingReturns) {
  const RenderScene scene(bodies(), light());
  geometry::RigidTransform pose;  // looks straight up
  pose.translation = Vec3(0.0, 0.0, 8.0);
  const auto frame = render(scene, camera(), pose, plain());
  EXPECT_EQ(*std::max_element(frame.depth_m.begin(), frame.depth_m.end()), 0.0F);
  EXPECT_EQ(*std::max_element(frame.instance.begin(), frame.instance.end()), 0);
  EXPECT_GT(frame.rgb[2], frame.rgb[0]);  // blue
}

TEST(Render, SameBytesForAnyNumberOfThreads) {
  const auto picture = [](int threads) {
    const base::ThreadLimit limit(threads);
    const RenderScene scene(bodies(), light());
    RenderOptions options;
    auto frame = render(scene, camera(), from_above({0.4, 0.3, 8.0}), options, 11, 2);
    add_depth_noise(frame, {}, 11, 2);
    return frame;
  };
  const auto one = picture(1), four = picture(4);
  EXPECT_EQ(one.rgb, four.rgb);
  EXPECT_EQ(one.depth_m, four.depth_m);
  EXPECT_EQ(one.instance, four.instance);
}

TEST(Render, TheSunThrowsShadows) {
  Lighting low = light();
  low.sun_azimuth_deg = 90.0;  // from the east: shadows fall west
  low.sun_elevation_deg = 35.0;
  const RenderScene scene(bodies(), low);
  const auto pose = from_above({0.0, 0.0, 8.0});
  const auto frame = render(scene, camera(), pose, plain());
  const auto brightness = [&](const Vec3& p) {
    const auto pixel = camera::project_world(camera(), pose, p);
    double sum = 0.0;
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) {
        const auto c = static_cast<std::size_t>(pixel->x() + dx), r = static_cast<std::size_t>(pixel->y() + dy);
        sum += frame.rgb[3 * (r * 160 + c) + 1] / 25.0;
      }
    return sum;
  };
  // The ball's centre casts its shadow 1.5 / tan(35 deg) = 2.14 m to the west.
  EXPECT_LT(brightness({-2.14, 0.0, 0.0}), 0.7 * brightness({-2.14, 3.0, 0.0}));
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double ma = 0.0, mb = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
  const auto n = static_cast<double>(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ma += a[i] / n;
    mb += b[i] / n;
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    aa += (a[i] - ma) * (a[i] - ma);
    bb += (b[i] - mb) * (b[i] - mb);
    ab += (a[i] - ma) * (b[i] - mb);
  }
  return ab / std::sqrt(aa * bb + 1e-12);
}

// What matchers of features live on: a patch of one view is found again in another where the geometry says, and not
// five pixels beside it.
TEST(Render, SurfacesLookTheSameFromTwoViews) {
  const RenderScene scene(bodies(), light());
  survey::Camera c = camera();
  c.width_px = 320;
  c.height_px = 240;
  c.fx_px = c.fy_px = 300.0;
  c.cx_px = 160.0;
  c.cy_px = 120.0;
  RenderOptions options;
  options.samples = 2;
  const auto pose_a = from_above({-4.0, 0.3, 9.0}), pose_b = from_above({-3.2, 0.0, 9.3});
  const auto a = render(scene, c, pose_a, options, 1, 1), b = render(scene, c, pose_b, options, 1, 2);
  const auto patch = [&](const RenderedFrame& frame, double x, double y) {
    std::vector<double> values;
    for (int dy = -5; dy <= 5; ++dy)
      for (int dx = -5; dx <= 5; ++dx)
        values.push_back(
            frame.rgb[3 * (static_cast<std::size_t>(y + dy) * 320 + static_cast<std::size_t>(x + dx)) + 1]);
    return values;
  };
  std::vector<double> same, beside;
  for (int y = 20; y < 220; y += 8)
    for (int x = 20; x < 300; x += 8) {
      const auto depth =
          static_cast<double>(a.depth_m[static_cast<std::size_t>(y) * 320 + static_cast<std::size_t>(x)]);
      const auto ray = camera::pixel_ray(c, pose_a, {x + 0.5, y + 0.5});
      const auto pixel = camera::project_world(c, pose_b, ray->origin + depth / -ray->direction.z() * ray->direction);
      if (!pixel || !camera::inside_image(c, *pixel, 0.1)) continue;
      const auto first = patch(a, x, y);
      same.push_back(correlation(first, patch(b, pixel->x(), pixel->y())));
      beside.push_back(std::abs(correlation(first, patch(b, pixel->x() + 5.0, pixel->y() - 5.0))));
    }
  const auto median = [](std::vector<double>& v) {
    std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
    return v[v.size() / 2];
  };
  ASSERT_GT(same.size(), 300U);
  EXPECT_GT(median(same), 0.6);  // whole-pixel patches: half a pixel of shift costs a fifth
  EXPECT_LT(median(beside), 0.4);
}

TEST(DepthNoise, GrowsWithTheSquareOfDepthAndLeavesHoles) {
  RenderedFrame frame;
  frame.width_px = 400;
  frame.height_px = 300;
  const auto noisy = [&](float depth, const DepthNoise& noise) {
    frame.depth_m.assign(400 * 300, depth);
    add_depth_noise(frame, noise, 3, 1);
    double sum = 0.0, lost = 0.0, n = 0.0;
    for (const float z : frame.depth_m) {
      if (z == 0.0F) {
        lost += 1.0;
        continue;
      }
      const double e = static_cast<double>(z) - static_cast<double>(depth);
      sum += e * e;
      n += 1.0;
    }
    return std::pair(n > 0.0 ? std::sqrt(sum / n) : 0.0, lost / 120000.0);
  };
  DepthNoise noise;
  noise.patch_hole = 0.0;
  // 120 000 draws: the deviation is known to 0.2 %.
  EXPECT_NEAR(noisy(2.0F, noise).first, noise.quadratic * 4.0, 0.02 * noise.quadratic * 4.0);
  EXPECT_NEAR(noisy(10.0F, noise).first, noise.quadratic * 100.0, 0.02 * noise.quadratic * 100.0);
  EXPECT_EQ(noisy(10.0F, noise).second, 0.0);
  EXPECT_EQ(noisy(25.0F, noise).second, 1.0);
  EXPECT_EQ(noisy(0.2F, noise).second, 1.0);
  noise.patch_hole = 0.05;
  const double lost = noisy(5.0F, noise).second;
  EXPECT_GT(lost, 0.015);
  EXPECT_LT(lost, 0.12);
  // A step: half the pixels of the two columns beside it.
  noise.patch_hole = 0.0;
  for (std::size_t i = 0; i < frame.depth_m.size(); ++i) frame.depth_m[i] = i % 400 < 200 ? 4.0F : 6.0F;
  add_depth_noise(frame, noise, 3, 1);
  const auto holes = std::count(frame.depth_m.begin(), frame.depth_m.end(), 0.0F);
  EXPECT_NEAR(static_cast<double>(holes), 300.0, 60.0);
}

TEST(DepthMillimetres, ZeroIsNoReturn) {
  RenderedFrame frame;
  frame.depth_m = {0.0F, 1.2344F, 65.535F, 65.6F, 0.0004F};
  EXPECT_EQ(depth_millimetres(frame), (std::vector<std::uint16_t>{0, 1234, 65535, 0, 0}));
}

TEST(RenderScene, RefusesWhatAMaskCannotHold) {
  auto all = bodies();
  all[1].object = 65534;
  EXPECT_THROW(RenderScene(all, light()), base::Error);
  Lighting dark = light();
  dark.sun_elevation_deg = -3.0;
  EXPECT_THROW(RenderScene(bodies(), dark), base::Error);
  RenderOptions options;
  options.samples = 0;
  EXPECT_THROW(static_cast<void>(render(RenderScene(bodies(), light()), camera(), {}, options)), base::Error);
}

}  // namespace
}  // namespace cairn::simulation
