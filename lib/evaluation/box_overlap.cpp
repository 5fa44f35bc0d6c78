#include "evaluation/box_overlap.hpp"

#include <algorithm>

namespace cairn::evaluation {

double intersection(const geometry::PixelBox& a, const geometry::PixelBox& b) {
  const double width = std::min(a.xmax, b.xmax) - std::max(a.xmin, b.xmin);
  const double height = std::min(a.ymax, b.ymax) - std::max(a.ymin, b.ymin);
  return width > 0.0 && height > 0.0 ? width * height : 0.0;
}

double iou(const geometry::PixelBox& a, const geometry::PixelBox& b) {
  const double both = intersection(a, b);
  const double either = a.area() + b.area() - both;
  return either > 0.0 ? both / either : 0.0;
}

}  // namespace cairn::evaluation
