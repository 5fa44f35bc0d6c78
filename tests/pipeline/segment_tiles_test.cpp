#include "pipeline/segment_tiles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "base/error.hpp"
#include "support/boulder_field.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec3;
using segmentation::Label;

TiledSegments segmented(const std::vector<Vec3>& points, double tile_m) {
  SegmentTilesOptions options;
  options.tile_m = tile_m;
  base::RunContext ctx;
  return segment_tiles(source_of(points), options, label_as_rock, ctx);
}

TEST(SegmentTiles, TilesOrNotTheSameInstances) {
  const auto field = testing::boulder_field(21, 400'000, 70.0, 60);
  const auto whole = segmented(field.points, 0.0);
  const auto tiled = segmented(field.points, 15.0);
  EXPECT_EQ(whole.tiles, 1U);
  EXPECT_GT(tiled.tiles, 15U);
  ASSERT_GT(whole.objects.size(), 45U);
  ASSERT_EQ(tiled.objects.size(), whole.objects.size());
  for (std::size_t i = 0; i < whole.objects.size(); ++i) {
    EXPECT_EQ(tiled.objects[i].points, whole.objects[i].points) << i;
    EXPECT_EQ(tiled.objects[i].target_id, whole.objects[i].target_id);
  }
  EXPECT_EQ(tiled.labels, whole.labels);
  EXPECT_EQ(tiled.ground, whole.ground);
}

TEST(SegmentTiles, IdsAndLabelsAgree) {
  const auto field = testing::boulder_field(22, 150'000, 35.0, 30);
  const auto result = segmented(field.points, 0.0);
  std::vector<Label> expected(field.points.size(), Label::unlabelled);
  std::uint32_t next = 0;
  for (const auto& object : result.objects) {
    EXPECT_EQ(object.target_id, next++);
    ASSERT_EQ(object.points.size(), object.labels.size());
    for (std::size_t i = 0; i < object.points.size(); ++i) {
      EXPECT_EQ(expected[object.points[i]], Label::unlabelled);  // no point twice
      expected[object.points[i]] = object.labels[i];
    }
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (expected[i] == Label::rock) EXPECT_EQ(result.labels[i], Label::rock);
    else EXPECT_TRUE(result.labels[i] == Label::terrain || result.labels[i] == Label::unlabelled);
  }
}

TEST(SegmentTiles, RejectedObjectsKeepTheirReasonAndNoPoint) {
  const auto field = testing::boulder_field(23, 60'000, 20.0, 12);
  base::RunContext ctx;
  const auto result = segment_tiles(
      source_of(field.points), {},
      [](const ObjectPatch& patch) {
        if (patch.object->height > 0.6) return label_as_rock(patch);
        ObjectLabels said;
        said.reason = "too_low";
        return said;
      },
      ctx);
  std::size_t accepted = 0, rejected = 0;
  for (const auto& object : result.objects) {
    if (object.reason.empty()) {
      ++accepted;
      EXPECT_GT(object.candidate.height, 0.6);
    } else {
      ++rejected;
      EXPECT_TRUE(object.points.empty());
      EXPECT_EQ(object.target_id, segmentation::kNoTarget);
    }
  }
  EXPECT_GT(accepted, 2U);
  EXPECT_GT(rejected, 0U);
}

TEST(SegmentTiles, BadInput) {
  base::RunContext ctx;
  const std::vector<Vec3> none, lost(3, Vec3::Constant(std::nan("")));
  EXPECT_THROW((void)segment_tiles(source_of(none), {}, label_as_rock, ctx), base::Error);
  EXPECT_THROW((void)segment_tiles(source_of(lost), {}, label_as_rock, ctx), base::Error);
  const auto field = testing::boulder_field(24, 50'000, 30.0, 5);
  ctx.memory_limit_bytes = 1;
  EXPECT_THROW((void)segment_tiles(source_of(field.points), {}, label_as_rock, ctx), base::Error);
}

}  // namespace
}  // namespace cairn::pipeline
