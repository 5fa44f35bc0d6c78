#include "detection/tiles.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cairn::detection {
namespace {

using geometry::PixelBox;

// Starts of pieces of `side` that cover `length`, evenly spread.
std::vector<std::size_t> starts(std::size_t length, std::size_t side, double overlap) {
  if (length <= side) return {0};
  const double step = std::max(1.0, std::floor(static_cast<double>(side) * (1.0 - overlap)));
  const std::size_t reach = length - side;
  const auto count = static_cast<std::size_t>(std::ceil(static_cast<double>(reach) / step));
  std::vector<std::size_t> result;
  // Whole steps from the left, the last at the border: tiles then stand at multiples of the step, and a network's
  // stride divides them where it divides the step.
  for (std::size_t i = 0; i < count; ++i) result.push_back(i * static_cast<std::size_t>(step));
  result.push_back(reach);
  return result;
}

PixelBox box_of(const PixelRect& r) {
  return {static_cast<double>(r.x), static_cast<double>(r.y), static_cast<double>(r.x + r.width),
          static_cast<double>(r.y + r.height)};
}

PixelBox clipped(const PixelBox& b, const PixelBox& to) {
  return {std::max(b.xmin, to.xmin), std::max(b.ymin, to.ymin), std::min(b.xmax, to.xmax), std::min(b.ymax, to.ymax)};
}

struct Cuts {
  bool left = false, top = false, right = false, bottom = false;
  [[nodiscard]] bool any() const { return left || top || right || bottom; }
};

Cuts cuts_of(const PixelBox& b, const PixelRect& tile, std::size_t width, std::size_t height, double border) {
  const PixelBox t = box_of(tile);
  return {tile.x > 0 && b.xmin<t.xmin + border, tile.y> 0 && b.ymin < t.ymin + border,
          tile.x + tile.width < width && b.xmax > t.xmax - border,
          tile.y + tile.height < height && b.ymax > t.ymax - border};
}

class Merger {
 public:
  Merger(std::span<const TileBox> boxes, std::span<const PixelRect> tiles, std::size_t width, std::size_t height,
         const SeamOptions& options)
      : boxes_(boxes), tiles_(tiles), options_(options), parent_(boxes.size()) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    for (const auto& b : boxes) cuts_.push_back(cuts_of(b.found.box, tiles[b.tile], width, height, options.border_px));
  }

  std::vector<ScoredBox> run() {
    for (std::size_t i = 0; i < boxes_.size(); ++i)
      for (std::size_t k = i + 1; k < boxes_.size(); ++k)
        if (parts_of_one(i, k)) join(i, k);
    return select(joined());
  }

 private:
  struct Candidate {
    ScoredBox found;
    bool cut = false;  // and no other part was found
  };

  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  // Cut by borders that face one another: a's tile ends inside b's and the other way round.
  [[nodiscard]] bool facing(std::size_t i, std::size_t k) const {
    const PixelRect &a = tiles_[boxes_[i].tile], &b = tiles_[boxes_[k].tile];
    const Cuts &ca = cuts_[i], &cb = cuts_[k];
    return (a.x < b.x && ca.right && cb.left) || (b.x < a.x && cb.right && ca.left) ||
           (a.y < b.y && ca.bottom && cb.top) || (b.y < a.y && cb.bottom && ca.top);
  }

  [[nodiscard]] bool parts_of_one(std::size_t i, std::size_t k) const {
    const TileBox &a = boxes_[i], &b = boxes_[k];
    if (a.tile == b.tile || a.found.object_class != b.found.object_class || !facing(i, k)) return false;
    const PixelBox both = clipped(box_of(tiles_[a.tile]), box_of(tiles_[b.tile]));
    if (!(both.width() > 0.0 && both.height() > 0.0)) return false;
    const PixelBox pa = clipped(a.found.box, both), pb = clipped(b.found.box, both);
    if (!(pa.width() > 0.0 && pa.height() > 0.0 && pb.width() > 0.0 && pb.height() > 0.0)) return false;
    return intersection_over_union(pa, pb) >= options_.seam_iou;
  }

  std::vector<Candidate> joined() {
    std::vector<Candidate> result;
    std::vector<std::size_t> place(boxes_.size(), boxes_.size());
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const std::size_t root = find(i);
      if (place[root] == boxes_.size()) {
        place[root] = result.size();
        result.push_back({boxes_[i].found, cuts_[i].any()});
        continue;
      }
      Candidate& c = result[place[root]];
      const ScoredBox& part = boxes_[i].found;
      c.found.box = {std::min(c.found.box.xmin, part.box.xmin), std::min(c.found.box.ymin, part.box.ymin),
                     std::max(c.found.box.xmax, part.box.xmax), std::max(c.found.box.ymax, part.box.ymax)};
      c.found.score = std::max(c.found.score, part.score);
      c.cut = false;
    }
    return result;
  }

  [[nodiscard]] std::vector<ScoredBox> select(std::vector<Candidate> candidates) const {
    std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return a.cut != b.cut ? !a.cut : a.found.score > b.found.score;
    });
    std::vector<ScoredBox> kept;
    for (const auto& c : candidates) {
      const bool known = std::any_of(kept.begin(), kept.end(), [&](const ScoredBox& k) {
        if (k.object_class != c.found.object_class) return false;
        return intersection_over_union(k.box, c.found.box) > options_.nms_iou ||
               (c.cut && share_inside(c.found.box, k.box) >= options_.contained);
      });
      if (!known) kept.push_back(c.found);
    }
    std::stable_sort(kept.begin(), kept.end(), [](const auto& a, const auto& b) { return a.score > b.score; });
    return kept;
  }

  std::span<const TileBox> boxes_;
  std::span<const PixelRect> tiles_;
  const SeamOptions& options_;
  std::vector<Cuts> cuts_;
  std::vector<std::size_t> parent_;
};

}  // namespace

std::vector<PixelRect> plan_tiles(std::size_t width, std::size_t height, const InputSize& tile, double overlap) {
  std::vector<PixelRect> tiles;
  for (const std::size_t y : starts(height, tile.height, overlap))
    for (const std::size_t x : starts(width, tile.width, overlap))
      tiles.push_back({x, y, std::min(tile.width, width), std::min(tile.height, height)});
  return tiles;
}

std::vector<ScoredBox> merge_tiles(std::span<const TileBox> boxes, std::span<const PixelRect> tiles, std::size_t width,
                                   std::size_t height, const SeamOptions& options) {
  return Merger(boxes, tiles, width, height, options).run();
}

}  // namespace cairn::detection
