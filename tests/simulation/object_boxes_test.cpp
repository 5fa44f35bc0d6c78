#include "simulation/object_boxes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "camera/projection.hpp"
#include "simulation/ground.hpp"
#include "support/views.hpp"
#include "visibility/scene.hpp"

namespace {

using namespace cairn;
using namespace cairn::simulation;
using geometry::Vec3;

survey::Camera bent_camera() {
  survey::Camera camera = r200_camera();
  camera.model = survey::CameraModel::brown;
  camera.k1 = -0.08;
  camera.k2 = 0.02;
  camera.p1 = 0.001;
  camera.p2 = -0.0005;
  return camera;
}

// A pedestal rock on rough ground.
struct Stage {
  Stage() {
    scene.terrain.relief_m = 1.0;
    scene.terrain.wavelength_m = 10.0;
    scene.terrain.min = {-10, -10};
    scene.terrain.max = {10, 10};
    ObjectSpec object;
    object.object_class = "pbr";
    object.position = geometry::Vec2(0.5, -0.5);
    object.shape.kind = ShapeKind::rock;
    object.shape.size_m = {2.0, 1.5, 1.8};
    object.shape.irregularity = 0.8;
    object.shape.edge_m = 0.06;
    object.shape.pedestal_height_m = 0.3;
    scene.objects = {object};
    mesh = terrain_mesh(scene.terrain);
    const Ground ground(mesh);
    placed = place_objects(scene, ground);
  }
  Scene scene;
  geometry::TriangleMesh mesh;
  std::vector<PlacedObject> placed;
};

// Pixels whose ray meets the mesh; every pixel of the image is cast.
std::optional<geometry::PixelBox> rendered(const geometry::TriangleMesh& mesh, const survey::Camera& camera,
                                           const geometry::RigidTransform& T) {
  const visibility::Scene scene(mesh);
  std::vector<geometry::Ray> rays;
  std::vector<geometry::Vec2> pixels;
  for (std::int64_t v = 0; v < camera.height_px; ++v)
    for (std::int64_t u = 0; u < camera.width_px; ++u) {
      const geometry::Vec2 pixel(static_cast<double>(u) + 0.5, static_cast<double>(v) + 0.5);
      if (const auto ray = camera::pixel_ray(camera, T, pixel)) {
        rays.push_back(*ray);
        pixels.push_back(pixel);
      }
    }
  const auto hits = scene.cast(rays);
  std::optional<geometry::PixelBox> box;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (!hits[i].hit()) continue;
    const auto& p = pixels[i];
    if (!box) box = {p.x() - 0.5, p.y() - 0.5, p.x() + 0.5, p.y() + 0.5};
    box = {std::min(box->xmin, p.x() - 0.5), std::min(box->ymin, p.y() - 0.5), std::max(box->xmax, p.x() + 0.5),
           std::max(box->ymax, p.y() + 0.5)};
  }
  return box;
}

TEST(ObjectBoxes, EqualTheRenderedMeshWithinAPixel) {
  const Stage stage;
  const auto& exposed = stage.placed[0].exposed;
  const ObjectOutline outline(exposed);
  constexpr double kPixel = 1.0;  // px: the grid of rays
  int whole = 0, cut = 0;
  for (const auto& camera : {r200_camera(), bent_camera()})
    for (int i = 0; i < 24; ++i) {
      const double a = 0.4 * i, reach = 4.0 + 0.5 * (i % 7);
      const Vec3 at(reach * std::cos(a), reach * std::sin(a), 2.0 + 0.4 * (i % 5));
      // Every second view looks past the rock, so that the image's border cuts it.
      const Vec3 aim = i % 2 == 0 ? Vec3(0.5, -0.5, 1.0) : Vec3(3.0 * std::sin(a), -3.0 * std::cos(a), 1.5);
      const auto T = cairn::testing::looking_at(at, aim);
      const auto expected = rendered(exposed, camera, T);
      const auto found = outline.seen(camera, T);
      if (!expected) continue;
      ASSERT_TRUE(found) << i;
      EXPECT_NEAR(found->box.xmin, expected->xmin, kPixel) << i;
      EXPECT_NEAR(found->box.ymin, expected->ymin, kPixel) << i;
      EXPECT_NEAR(found->box.xmax, expected->xmax, kPixel) << i;
      EXPECT_NEAR(found->box.ymax, expected->ymax, kPixel) << i;
      const bool at_border =
          expected->xmin <= 0.0 || expected->ymin <= 0.0 || expected->xmax >= 640.0 || expected->ymax >= 480.0;
      if (found->whole) {
        ++whole;
        EXPECT_EQ(found->inside_share, 1.0);
      } else {
        ++cut;
        EXPECT_TRUE(at_border) << i;
      }
    }
  EXPECT_GT(whole, 10);
  EXPECT_GT(cut, 5);
}

TEST(ObjectBoxes, NothingBehindTheCameraOrBesideTheImage) {
  const Stage stage;
  const ObjectOutline outline(stage.placed[0].exposed);
  EXPECT_FALSE(outline.seen(r200_camera(), cairn::testing::looking_at({0, -8, 2}, {0, -20, 2})));
  EXPECT_FALSE(outline.seen(r200_camera(), cairn::testing::looking_at({0, -8, 2}, {30, -8, 2})));
}

TEST(ObjectBoxes, VisibleShareIsThatOfThePixels) {
  Stage stage;
  // A wall in front of the rock's eastern half, seen from the south.
  ObjectSpec wall;
  wall.object_class = "wall";
  wall.position = geometry::Vec2(1.5, -3.0);
  wall.shape.kind = ShapeKind::box;
  wall.shape.size_m = {2.0, 0.2, 4.0};
  wall.shape.azimuth_deg = 90.0;
  stage.scene.objects.push_back(wall);
  const Ground ground(stage.mesh);
  const auto placed = place_objects(stage.scene, ground);
  const Obstruction obstruction(stage.mesh, placed);
  const ObjectOutline outline(placed[0].exposed);
  const auto camera = r200_camera();
  const visibility::Scene alone(placed[0].exposed), blocking(placed[1].shape.body);
  for (const double east : {-1.0, 0.0, 0.5, 1.0, 2.0}) {
    const auto T = cairn::testing::looking_at({east, -9.0, 2.5}, {0.5, -0.5, 1.0});
    double seen = 0, all = 0;
    for (int v = 0; v < 480; v += 2)
      for (int u = 0; u < 640; u += 2) {
        const auto ray = camera::pixel_ray(camera, T, {u + 0.5, v + 0.5});
        if (!alone.cast(std::span(&*ray, 1))[0].hit()) continue;
        ++all;
        if (!blocking.cast(std::span(&*ray, 1))[0].hit()) ++seen;
      }
    constexpr double kSampling = 0.15;  // about 50 rays: two standard errors
    EXPECT_NEAR(obstruction.visible_share(0, outline, camera, T), seen / all, kSampling) << east;
  }
}

}  // namespace
