// Large photographs cut into overlapping tiles, and boxes joined across their seams.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "detection/letterbox.hpp"
#include "detection/suppression.hpp"

namespace cairn::detection {

// Tiles of `tile` (at most) that cover width x height, in rows from the top left. Neighbours share at least `overlap`
// (0 .. 0.9) of a tile's side; the last one of a row or column ends at the border, so all have the same size where the
// image is that large. A single tile where the image is not larger.
[[nodiscard]] std::vector<PixelRect> plan_tiles(std::size_t width, std::size_t height, const InputSize& tile,
                                                double overlap);

// A box found in one tile, in image px.
struct TileBox {
  ScoredBox found;
  std::size_t tile = 0;  // index into the tiles
};

struct SeamOptions {
  double nms_iou = 0.45;   // two boxes of one class above this are one object
  double border_px = 3.0;  // a box whose side is nearer than this to its tile's inner border is cut by it
  double seam_iou = 0.5;   // parts of one object: their IoU where both tiles look, at least this
  double contained = 0.7;  // a cut box with this share inside another box is a part of it
};

// One box an object:
//  1. two boxes cut by facing borders of two tiles, of one class, that agree where both tiles look (seam_iou), are
//  parts
//     of one object: their union, with the greater score; chains of parts join too (an object over four tiles);
//  2. of whole and joined boxes that overlap by more than nms_iou the better score stays, a whole box before a cut one;
//  3. a cut box that lies in a box that stays (contained) is dropped.
// Deterministic; ties go to the earlier box. Cost: n^2 of one image's boxes.
[[nodiscard]] std::vector<ScoredBox> merge_tiles(std::span<const TileBox> boxes, std::span<const PixelRect> tiles,
                                                 std::size_t width, std::size_t height, const SeamOptions& options);

}  // namespace cairn::detection
