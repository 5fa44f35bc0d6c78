#include "detection/tiles.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/random.hpp"

namespace {

using namespace cairn::detection;
using cairn::geometry::PixelBox;

TEST(PlanTiles, OneWhereTheImageIsNotLarger) {
  const auto tiles = plan_tiles(300, 200, {320, 320}, 0.25);
  ASSERT_EQ(tiles.size(), 1U);
  EXPECT_EQ(tiles[0].width, 300U);
  EXPECT_EQ(tiles[0].height, 200U);
}

TEST(PlanTiles, CoverTheImageAndOverlapEnough) {
  for (const std::size_t width : {321U, 640U, 1000U, 4000U})
    for (const double overlap : {0.0, 0.25, 0.6}) {
      const auto tiles = plan_tiles(width, 320, {320, 320}, overlap);
      EXPECT_EQ(tiles.front().x, 0U);
      EXPECT_EQ(tiles.back().x + tiles.back().width, width);
      for (std::size_t i = 1; i < tiles.size(); ++i) {
        EXPECT_EQ(tiles[i].width, 320U);
        EXPECT_GT(tiles[i].x, tiles[i - 1].x);
        EXPECT_GE(static_cast<double>(tiles[i - 1].x + 320 - tiles[i].x), overlap * 320.0 - 1e-9);
      }
    }
  EXPECT_EQ(plan_tiles(640, 640, {320, 320}, 0.0).size(), 4U);
}

constexpr std::size_t kWidth = 1000, kHeight = 800;
const InputSize kTile{320, 320};

// What perfect detectors in each tile would see of an object: its part inside, where that is at least a tenth.
std::vector<TileBox> seen(const std::vector<PixelRect>& tiles, const PixelBox& object, std::size_t object_class = 0) {
  std::vector<TileBox> boxes;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const auto& t = tiles[i];
    const PixelBox part{std::max(object.xmin, static_cast<double>(t.x)),
                        std::max(object.ymin, static_cast<double>(t.y)),
                        std::min(object.xmax, static_cast<double>(t.x + t.width)),
                        std::min(object.ymax, static_cast<double>(t.y + t.height))};
    if (part.width() <= 0.0 || part.height() <= 0.0 || part.area() < 0.1 * object.area()) continue;
    boxes.push_back({{part, object_class, 0.5 + 0.4 * part.area() / object.area()}, i});
  }
  return boxes;
}

void expect_once(const PixelBox& object) {
  const auto tiles = plan_tiles(kWidth, kHeight, kTile, 0.25);
  const auto boxes = seen(tiles, object);
  ASSERT_FALSE(boxes.empty());
  const auto merged = merge_tiles(boxes, tiles, kWidth, kHeight, {});
  ASSERT_EQ(merged.size(), 1U) << object.xmin << " " << object.ymin << " " << object.xmax << " " << object.ymax;
  EXPECT_EQ(merged[0].box, object);
}

TEST(MergeTiles, AnObjectInsideOneTileIsLeftAlone) {
  expect_once({20, 20, 80, 90});
}
TEST(MergeTiles, AnObjectInTheOverlapOfTwoTilesIsFoundOnce) {
  expect_once({250, 50, 310, 100});
}
// Wider than the overlap: cut in both tiles, joined.
TEST(MergeTiles, AnObjectLargerThanTheOverlapIsJoined) {
  expect_once({180, 50, 380, 120});
}
TEST(MergeTiles, AnObjectOverFourTilesIsJoined) {
  expect_once({190, 190, 390, 400});
}
TEST(MergeTiles, AnObjectOverThreeTilesInARowIsJoined) {
  expect_once({100, 50, 700, 130});
}
TEST(MergeTiles, AnObjectAtTheImageBorderIsNotTakenForCut) {
  expect_once({0, 0, 60, 60});
  expect_once({940, 740, 1000, 800});
}

TEST(MergeTiles, AnywhereSmallObjectsAreFoundOnceAndWhole) {
  cairn::base::Random random(4, "tiles", 0);
  for (int i = 0; i < 500; ++i) {
    const double w = 10 + 69 * random.uniform(), h = 10 + 69 * random.uniform();
    const double x = random.uniform() * (kWidth - w), y = random.uniform() * (kHeight - h);
    expect_once({x, y, x + w, y + h});
  }
}

TEST(MergeTiles, NeighboursAndOtherClassesStayApart) {
  const auto tiles = plan_tiles(kWidth, kHeight, kTile, 0.25);
  // Two objects side by side across the seam, each in the overlap.
  auto boxes = seen(tiles, {245, 50, 278, 100});
  for (const auto& b : seen(tiles, {282, 50, 316, 100})) boxes.push_back(b);
  EXPECT_EQ(merge_tiles(boxes, tiles, kWidth, kHeight, {}).size(), 2U);
  boxes = seen(tiles, {180, 50, 380, 120}, 0);
  for (const auto& b : seen(tiles, {180, 50, 380, 120}, 1)) boxes.push_back(b);
  EXPECT_EQ(merge_tiles(boxes, tiles, kWidth, kHeight, {}).size(), 2U);
}

TEST(MergeTiles, ACutPartBesideItsWholeIsDropped) {
  const auto tiles = plan_tiles(kWidth, kHeight, kTile, 0.25);
  // Whole in the first tile, its right end in the second with a better score.
  const std::vector<TileBox> boxes{{{{200, 50, 318, 100}, 0, 0.6}, 0}, {{{240, 50, 318, 100}, 0, 0.9}, 1}};
  SeamOptions options;
  options.border_px = 1.0;
  const auto merged = merge_tiles(boxes, tiles, kWidth, kHeight, options);
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_EQ(merged[0].box, boxes[0].found.box);
}

}  // namespace
