#include "tracking/screen.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/number_text.hpp"

namespace cairn::tracking {
namespace {

BoxFault fault_of(const BoxObservation& o, double min_score) {
  for (const double value : {o.box.xmin, o.box.ymin, o.box.xmax, o.box.ymax, o.score})
    if (!std::isfinite(value)) return BoxFault::non_finite_box;
  // Widths whose product or ratio leaves the range of a double have no finite state.
  if (!std::isfinite(o.box.area()) || !std::isfinite(o.box.width() / o.box.height())) {
    if (o.box.height() != 0.0) return BoxFault::non_finite_box;
  }
  if (o.box.width() < 0.0 || o.box.height() < 0.0) return BoxFault::negative_size_box;
  if (!(o.box.area() > 0.0)) return BoxFault::zero_area_box;
  if (o.score < min_score) return BoxFault::low_score;
  return BoxFault::none;
}

auto key(const BoxObservation& o) {
  return std::tie(o.object_class, o.box.xmin, o.box.ymin, o.box.xmax, o.box.ymax);
}

}  // namespace

const char* name_of(BoxFault fault) {
  switch (fault) {
    case BoxFault::none: return "none";
    case BoxFault::non_finite_box: return "non_finite_box";
    case BoxFault::negative_size_box: return "negative_size_box";
    case BoxFault::zero_area_box: return "zero_area_box";
    case BoxFault::duplicate_box: return "duplicate_box";
    case BoxFault::low_score: return "low_score";
  }
  return "none";
}

std::string describe(BoxFault fault, const BoxObservation& o) {
  const std::string size = base::to_text(o.box.width()) + " x " + base::to_text(o.box.height()) + " px";
  switch (fault) {
    case BoxFault::none: return "";
    case BoxFault::non_finite_box: return "a side, the size or the score is not a finite number";
    case BoxFault::negative_size_box: return "the box ends before it begins: " + size;
    case BoxFault::zero_area_box: return "the box has no area: " + size;
    case BoxFault::duplicate_box: return "an earlier box of the frame has the same class and sides";
    case BoxFault::low_score: return "the score " + base::to_text(o.score) + " is below the least one asked for";
  }
  return "";
}

std::vector<BoxFault> screen_boxes(std::span<const BoxObservation> boxes, double min_score, bool keep_duplicates) {
  std::vector<BoxFault> faults(boxes.size());
  std::vector<std::size_t> order;
  order.reserve(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    faults[i] = fault_of(boxes[i], min_score);
    if (faults[i] == BoxFault::none) order.push_back(i);
  }
  if (keep_duplicates) return faults;
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto ka = key(boxes[a]), kb = key(boxes[b]);
    return ka != kb ? ka < kb : a < b;
  });
  for (std::size_t i = 1; i < order.size(); ++i)
    if (key(boxes[order[i - 1]]) == key(boxes[order[i]])) faults[order[i]] = BoxFault::duplicate_box;
  return faults;
}

}  // namespace cairn::tracking
