#include "detection/suppression.hpp"

#include <algorithm>

namespace cairn::detection {
namespace {

double shared_area(const geometry::PixelBox& a, const geometry::PixelBox& b) {
  const double w = std::min(a.xmax, b.xmax) - std::max(a.xmin, b.xmin);
  const double h = std::min(a.ymax, b.ymax) - std::max(a.ymin, b.ymin);
  return w > 0.0 && h > 0.0 ? w * h : 0.0;
}

}  // namespace

double intersection_over_union(const geometry::PixelBox& a, const geometry::PixelBox& b) {
  const double shared = shared_area(a, b);
  return shared > 0.0 ? shared / (a.area() + b.area() - shared) : 0.0;
}

double share_inside(const geometry::PixelBox& part, const geometry::PixelBox& whole) {
  const double shared = shared_area(part, whole);
  return shared > 0.0 ? shared / part.area() : 0.0;
}

std::vector<ScoredBox> suppress(std::span<const ScoredBox> boxes, double iou) {
  std::vector<ScoredBox> sorted(boxes.begin(), boxes.end());
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const ScoredBox& a, const ScoredBox& b) { return a.score > b.score; });
  std::vector<ScoredBox> kept;
  for (const auto& box : sorted) {
    const bool taken = std::any_of(kept.begin(), kept.end(), [&](const ScoredBox& better) {
      return better.object_class == box.object_class && intersection_over_union(better.box, box.box) > iou;
    });
    if (!taken) kept.push_back(box);
  }
  return kept;
}

}  // namespace cairn::detection
