#include "pipeline/rock_figures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/rock_products.hpp"
#include "support/bodies.hpp"
#include "support/brighton_beach.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec3;
using ::testing::HasSubstr;

// Boulder B03 of the sample (objects.csv): centre by triangulation, local ENU.
const Vec3 kBoulder(28.167, 8.313, 3.244);

// A box of the boulder's size on the ground, with its rim as contact.
RockResult boulder() {
  RockResult r;
  r.stem = "3";
  r.mesh = testing::moved(testing::block(0.87, 0.87, 0.6), kBoulder - Vec3(0, 0, 0.4));
  r.rock.target = survey::TargetId(3);
  r.rock.object_class = "boulder";
  r.rock.density_kg_m3 = 2600.0;
  r.rock.mass = geometry::mass_properties(r.mesh);
  r.rock.tipping.contact.assign(r.mesh.vertices.begin(), r.mesh.vertices.begin() + 4);
  r.rock.tipping.critical = survey::TippingEdge{};
  r.rock.tipping.critical->azimuth_deg = 90.0;
  r.rock.tipping.critical->alpha_rad = 0.9;
  r.rock.tipping.critical->a_qs_g = 1.3;
  return r;
}

survey::Contact rim_of(const RockResult& r) {
  survey::Contact contact;
  for (const auto& p : r.rock.tipping.contact) {
    survey::ContactVertex v;
    v.order = static_cast<std::int64_t>(contact.size());
    v.position = p;
    v.observed = true;
    contact.push_back(v);
  }
  return contact;
}

TEST(RockPhotos, FindTheFramesThatShowTheBoulder) {
  const auto survey = testing::brighton_beach_colmap();
  const auto r = boulder();
  const auto photos = rock_photos(r.mesh, rim_of(r), survey, 3);
  ASSERT_GE(photos.size(), 2U);
  ASSERT_LE(photos.size(), 3U);
  for (const auto& photo : photos) {
    EXPECT_GE(photo.box.xmin, 0.0);
    EXPECT_LE(photo.box.xmax, 1600.0);
    EXPECT_GE(std::max(photo.box.width(), photo.box.height()), 24.0);
    EXPECT_EQ(photo.hidden.size(), 4U);
    EXPECT_GT(photo.contact_in_sight, 0.0);
  }
  EXPECT_TRUE(rock_photos(testing::moved(r.mesh, Vec3(500, 0, 0)), {}, survey, 3).empty());
  EXPECT_TRUE(rock_photos({}, {}, survey, 3).empty());
}

// A far corner of the rim is hidden by the rock itself when seen from a low camera.
TEST(RockPhotos, TheRockHidesItsFarRim) {
  auto survey = testing::brighton_beach_colmap();
  survey.frames.resize(1);
  auto& frame = survey.frames.front();
  const auto r = boulder();
  // 6 m west, level with the middle, looking east.
  frame.T_world_camera.translation = kBoulder + Vec3(-6, 0, 0);
  frame.T_world_camera.rotation.col(0) = Vec3(0, -1, 0);
  frame.T_world_camera.rotation.col(1) = Vec3(0, 0, -1);
  frame.T_world_camera.rotation.col(2) = Vec3(1, 0, 0);
  const auto photos = rock_photos(r.mesh, rim_of(r), survey, 1);
  ASSERT_EQ(photos.size(), 1U);
  EXPECT_NEAR(photos[0].azimuth_deg, 90.0, 1.0);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(photos[0].hidden[i] != 0, r.rock.tipping.contact[i].x() > kBoulder.x()) << i;
}

TEST(FigureFiles, WriteSectionsViewsAndPhotographs) {
  const testing::TempFolder folder;
  auto survey = testing::brighton_beach_colmap();
  survey.manifest.name = "Brighton Beach";
  for (auto& f : survey.frames) {
    f.image = (testing::sample("brighton_beach/images_1600") / f.image).string();
    f.T_world_camera = io::exact_pose(f.T_world_camera);
  }
  survey.ties.clear();
  std::filesystem::create_directory(folder / "survey");
  io::write_survey(survey, folder / "survey");
  base::RunContext ctx;
  for (const char* name : {"a", "b"}) {
    std::filesystem::create_directory(folder / name);
    const auto outcome = figure_files({boulder()}, folder.path(), folder / "survey", folder / name, {}, ctx);
    EXPECT_EQ(outcome.summary.at("figures").at("sections").as_integer(), 1);
    EXPECT_GE(outcome.summary.at("figures").at("photographs").as_integer(), 2);
  }
  EXPECT_TRUE(ctx.warnings().empty());
  const std::string photo = base::read_file(folder / "a/3_photo_1.svg");
  EXPECT_THAT(photo, HasSubstr("data:image/jpeg;base64,"));
  EXPECT_THAT(photo, HasSubstr("#ffd23f"));
  EXPECT_EQ(photo, base::read_file(folder / "b/3_photo_1.svg"));
  EXPECT_EQ(base::read_file(folder / "a/3_views.svg"), base::read_file(folder / "b/3_views.svg"));
}

TEST(AddRockProducts, RefusesASurveyWithoutFigures) {
  Outcome outcome;
  base::RunContext ctx;
  RockProductOptions options;
  options.survey = "somewhere";
  EXPECT_THROW(add_rock_products("mesh.ply", "results", options, {}, outcome, ctx), base::Error);
  options.survey.clear();
  add_rock_products("mesh.ply", "results", options, {}, outcome, ctx);  // nothing asked, nothing read
}

}  // namespace
}  // namespace cairn::pipeline
