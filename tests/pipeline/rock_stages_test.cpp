// segment, surface and fragility as a recipe runs them, on a small made-up site.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/rocks_json.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/fragility_stage.hpp"
#include "pipeline/segment_stage.hpp"
#include "pipeline/surface_stage.hpp"
#include "support/data.hpp"
#include "support/small_rocks.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;

void write_site(const fs::path& folder) {
  testing::write_small_rocks(folder);
  survey::Survey survey;
  survey.manifest.name = "small rocks";
  survey.manifest.origin.position = {46.8426, -91.994, 158.0};
  survey.manifest.origin.height_type = survey::HeightType::ellipsoidal;
  survey::Source cloud;
  cloud.kind = "cloud";
  cloud.path = (folder / "cloud.las").string();
  cloud.crs = "local";
  cloud.height_type = survey::HeightType::ellipsoidal;
  survey.manifest.sources.push_back(cloud);
  fs::create_directories(folder / "survey");
  io::write_survey(survey, folder / "survey");
}

TEST(RockStages, FromSurveyToRecords) {
  const testing::TempFolder folder;
  write_site(folder.path());
  base::RunContext ctx;
  // Each stage writes straight into the products here; targets.json stands there already.
  const StageInputs in{folder / "survey", folder.path(), {"locate", "segment", "surface"}};
  const auto segmented = make_segment_stage()->run(in, folder.path(), ctx);
  EXPECT_EQ(segmented.summary.at("rocks").as_integer(), 2);
  EXPECT_TRUE(fs::exists(folder / "labelled.las"));
  const auto surfaces = make_surface_stage()->run(in, folder.path(), ctx);
  EXPECT_EQ(surfaces.summary.at("rocks").as_integer(), 2);
  const auto graded = make_fragility_stage()->run(in, folder.path(), ctx);
  EXPECT_EQ(graded.summary.at("assessed").as_integer(), 2);

  const auto file = io::read_rocks(folder / "rocks.json");
  EXPECT_EQ(file.frame.position.latitude_deg, 46.8426);
  ASSERT_EQ(file.rocks.size(), 4U);
  std::vector<std::string> reasons;
  for (const auto& rock : file.rocks) {
    const auto id = std::to_string(rock.target.value);
    EXPECT_EQ(rock.object_class, "boulder");
    EXPECT_EQ(rock.rejected, rock.target.value > 2) << id;
    EXPECT_EQ(rock.mass.has_value(), !rock.rejected);
    EXPECT_EQ(fs::exists(folder / ("rocks/" + id + ".glb")), !rock.rejected);
    EXPECT_EQ(rock.tipping.critical.has_value(), rock.tipping.grade != survey::Grade::not_measurable);
    EXPECT_EQ(fs::exists(folder / ("rocks/" + id + "_tipping.svg")), rock.tipping.critical.has_value());
    if (rock.rejected) reasons.push_back(rock.reasons.at(0));
    else {
      EXPECT_TRUE(rock.density_assumed);
      EXPECT_EQ(rock.density_kg_m3, 2600.0);
      EXPECT_NEAR(rock.base_height_m, 20.0, 0.02);
    }
  }
  EXPECT_THAT(reasons, ::testing::ElementsAre("not_above_ground", "cloud_missing"));
  const auto& post = file.rocks[1];
  // Closed on the line that the segmentation saw; where it saw none, on the ground, and then the rock is screened at
  // best.
  EXPECT_EQ(post.cap, post.tipping.contact_assumed ? survey::CapModel::plane : survey::CapModel::patch);
  if (post.tipping.contact_assumed) {
    EXPECT_EQ(post.tipping.grade, survey::Grade::screening);
  }
  EXPECT_EQ(post.tipping.a_qs_g_by_azimuth.size(), 360U);
  EXPECT_NEAR(post.size_m.x(), 1.0, 0.02);
  EXPECT_NEAR(post.size_m.z(), 1.2, 0.02);
}

TEST(RockStages, NoRocksIsNoError) {
  const testing::TempFolder folder;
  write_site(folder.path());
  io::TargetsFile none;
  none.frame.position = {46.8426, -91.994, 158.0};
  none.frame.height_type = survey::HeightType::ellipsoidal;
  io::write_targets(folder / "targets.json", none);
  base::RunContext ctx;
  const StageInputs in{folder / "survey", folder.path(), {"locate"}};
  EXPECT_EQ(make_segment_stage()->run(in, folder.path(), ctx).summary.at("rocks").as_integer(), 0);
  EXPECT_EQ(make_surface_stage()->run(in, folder.path(), ctx).summary.at("rocks").as_integer(), 0);
  (void)make_fragility_stage()->run(in, folder.path(), ctx);
  EXPECT_TRUE(io::read_rocks(folder / "rocks.json").rocks.empty());
}

}  // namespace
}  // namespace cairn::pipeline
