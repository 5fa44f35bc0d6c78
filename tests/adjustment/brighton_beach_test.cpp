// The real survey: what must be found, and what must not be blamed.
#include <gmock/gmock.h>

#include <GeographicLib/UTMUPS.hpp>

#include "adjustment/evidence_cloud.hpp"
#include "adjustment/evidence_pairs.hpp"
#include "adjustment/evidence_ties.hpp"
#include "io/image.hpp"
#include "support/brighton_beach.hpp"

namespace cairn::adjustment {
namespace {

using geometry::GreyImage;
using geometry::Vec2;
using geometry::Vec3;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const std::vector<GreyImage>& images() {
  static const std::vector<GreyImage> all = [] {
    std::vector<GreyImage> result;
    for (int number = 18; number <= 35; ++number) {
      const auto path = testing::sample("brighton_beach/images_1600/DJI_00" + std::to_string(number) + ".JPG");
      result.push_back(io::read_grey_image(path));
    }
    return result;
  }();
  return all;
}

const GreyImage& image_of(const survey::Frame& frame) {
  return images().at(static_cast<std::size_t>(std::stoi(frame.image.substr(6, 2)) - 18));
}

std::vector<MatchedPair> matched(const survey::Survey& survey) {
  std::vector<GreyImage> in_order;
  for (const auto& frame : survey.frames) in_order.push_back(image_of(frame));
  const auto pairs = neighbour_pairs(survey);
  const auto matches = match_images(in_order, pairs);
  std::vector<MatchedPair> result;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    result.push_back({survey.frames[pairs[i].first].id, survey.frames[pairs[i].second].id, matches[i]});
  return result;
}

geometry::PointCloud cloud_local() {
  auto cloud = testing::brighton_beach_cloud_utm();
  const geodesy::LocalFrame local(testing::brighton_beach_origin());
  for (auto& p : cloud.positions) {
    double latitude = 0.0, longitude = 0.0;
    GeographicLib::UTMUPS::Reverse(15, true, p.x(), p.y(), latitude, longitude);
    p = local.to_local({latitude, longitude, p.z()});
  }
  return cloud;
}

std::vector<FrameImage> frame_images(const survey::Survey& survey) {
  std::vector<FrameImage> result;
  for (const auto& frame : survey.frames) result.push_back({frame.id, &image_of(frame)});
  return result;
}

TEST(BrightonBeach, TiePointsOfColmapReproject) {
  const auto evidence = tie_evidence(testing::brighton_beach_colmap(1.0));
  EXPECT_EQ(evidence.points, 4881U);
  EXPECT_EQ(evidence.observations, 19804U);
  EXPECT_LT(evidence.median_px, 1.0);  // README: mean 0.806 px
  EXPECT_THAT(evidence.verdicts, IsEmpty());
  EXPECT_THAT(evidence.unexplained, IsEmpty());
}

TEST(BrightonBeach, PairsOfColmapAreSound) {
  const auto survey = testing::brighton_beach_colmap();
  const auto evidence = pair_evidence(survey, matched(survey));
  EXPECT_THAT(evidence.verdicts, IsEmpty());
  EXPECT_THAT(evidence.unexplained, IsEmpty());
  EXPECT_THAT(evidence.unmatched, IsEmpty());
}

TEST(BrightonBeach, ExifPosesShowTheSixTurnedFrames) {
  const auto survey = testing::brighton_beach_exif();
  const auto evidence = pair_evidence(survey, matched(survey));
  ASSERT_THAT(evidence.verdicts, SizeIs(1));
  EXPECT_EQ(evidence.verdicts[0].code, "frame_turned_180");
  std::vector<survey::FrameId> expected;
  for (std::int64_t id = 24; id <= 29; ++id) expected.emplace_back(id);
  EXPECT_EQ(evidence.verdicts[0].frames, expected);
  EXPECT_THAT(evidence.unexplained, IsEmpty());
}

// README: cloud minus colmap_enu is +0.57 m east, 0.00 m north, +0.92 m up.
TEST(BrightonBeach, CloudLiesBesideThePoses) {
  const auto survey = testing::brighton_beach_colmap();
  const auto evidence = cloud_evidence(survey, frame_images(survey), cloud_surface(cloud_local()));
  constexpr double kToleranceM = 0.1;  // what the remedy must be told
  ASSERT_TRUE(evidence.horizontal_m && evidence.vertical_m);
  EXPECT_NEAR(evidence.horizontal_m->x(), 0.57, kToleranceM);
  EXPECT_NEAR(evidence.horizontal_m->y(), 0.0, kToleranceM);
  EXPECT_NEAR(*evidence.vertical_m, 0.92, kToleranceM);
  EXPECT_EQ(evidence.vertical_by, "tie_points");
}

TEST(BrightonBeach, CloudOffsetWithoutTiePoints) {
  auto survey = testing::brighton_beach_colmap();
  survey.ties.clear();
  const auto evidence = cloud_evidence(survey, frame_images(survey), cloud_surface(cloud_local()));
  ASSERT_TRUE(evidence.horizontal_m && evidence.vertical_m);
  constexpr double kHorizontalM = 0.15, kVerticalM = 0.3;  // from views at most 42 degrees off the vertical
  EXPECT_NEAR(evidence.horizontal_m->x(), 0.57, kHorizontalM);
  EXPECT_NEAR(evidence.horizontal_m->y(), 0.0, kHorizontalM);
  EXPECT_NEAR(*evidence.vertical_m, 0.92, kVerticalM);
  EXPECT_EQ(evidence.vertical_by, "parallax");
}

// enu_frame.json holds cloud <- colmap_enu; its inverse brings the cloud to the poses.
TEST(BrightonBeach, DeclaredSimilarityRemovesTheOffset) {
  const auto survey = testing::brighton_beach_colmap();
  geometry::Similarity T_cloud_world;
  T_cloud_world.scale = 0.9993635800737055;
  T_cloud_world.rotation << 0.9999979114066242, -0.0015376814150589702, 0.001346372257515778, 0.0015372765947553645,
      0.9999987728907668, 0.000301658136371917, -0.001346834459479987, -0.0002995877597713609, 0.9999990481416032;
  T_cloud_world.translation = {0.5785944402766834, -0.010247809102231775, 0.9361352258419946};
  auto cloud = cloud_local();
  const auto T_world_cloud = T_cloud_world.inverse();
  for (auto& p : cloud.positions) p = T_world_cloud * p;
  const auto evidence = cloud_evidence(survey, frame_images(survey), cloud_surface(cloud));
  constexpr double kResidualM = 0.1;
  ASSERT_TRUE(evidence.horizontal_m && evidence.vertical_m);
  EXPECT_LT(evidence.horizontal_m->norm(), kResidualM);
  EXPECT_LT(std::abs(*evidence.vertical_m), kResidualM);
}

}  // namespace
}  // namespace cairn::adjustment
