#include "pipeline/segment_tiles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "io/las.hpp"
#include "pipeline/segment_las.hpp"
#include "support/boulder_field.hpp"
#include "support/data.hpp"

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
  std::uint32_t next = 1;
  for (const auto& object : result.objects) {
    EXPECT_EQ(object.target_id, next++);
    ASSERT_EQ(object.points.size(), object.labels.size());
    for (std::size_t i = 0; i < object.points.size(); ++i) {
      EXPECT_EQ(expected[object.points[i]], Label::unlabelled);  // no point twice
      expected[object.points[i]] = object.labels[i];
    }
  }
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (expected[i] == Label::rock) {
      EXPECT_EQ(result.labels[i], Label::rock);
    } else {
      EXPECT_TRUE(result.labels[i] == Label::terrain || result.labels[i] == Label::unlabelled);
    }
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
    }
  }
  EXPECT_GT(accepted, 2U);
  EXPECT_GT(rejected, 0U);
}

TEST(SegmentTiles, LasFilesInPieces) {
  const auto field = testing::boulder_field(25, 150'000, 30.0, 20);
  const testing::TempFolder folder;
  geometry::PointCloud cloud;
  cloud.positions = field.points;
  cloud.intensity.assign(cloud.size(), 7);
  io::write_las(folder.path() / "in.las", cloud);
  SegmentTilesOptions options;
  options.tile_m = 12.0;
  base::RunContext ctx;
  const auto shift = [](std::vector<Vec3>& points) {
    for (Vec3& p : points) p += Vec3(1000.0, -500.0, 20.0);
  };
  const auto result =
      segment_las_by_tiles(folder.path() / "in.las", folder.path() / "out.las", options, label_as_rock, shift, ctx);
  EXPECT_GT(result.objects.size(), 14U);
  const auto out = io::read_las(folder.path() / "out.las").cloud;
  ASSERT_EQ(out.size(), cloud.size());
  EXPECT_EQ(out.intensity, cloud.intensity);
  const auto& label = out.scalar("label")->values;
  const auto& target = out.scalar("target_id")->values;
  const auto& probability = out.scalar("probability")->values;
  std::vector<double> expected(cloud.size(), segmentation::kNoTarget);
  for (const auto& object : result.objects)
    for (const std::uint64_t i : object.points) expected[i] = object.target_id;
  EXPECT_EQ(target, expected);
  for (std::size_t i = 0; i < label.size(); ++i) {
    EXPECT_EQ(label[i], static_cast<double>(result.labels[i]));
    EXPECT_EQ(probability[i], label[i] == 0.0 ? 0.0 : 1.0);
  }
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
