// A part of an image fitted into a network's input without changing its proportions.
#pragma once

#include <cstddef>

#include "geometry/primitives.hpp"

namespace cairn::detection {

// Whole pixels of an image: columns x..x + width, rows y..y + height.
struct PixelRect {
  std::size_t x = 0, y = 0, width = 0, height = 0;
};

struct InputSize {
  std::size_t width = 0, height = 0;
};

// The part is scaled to scaled_width x scaled_height and placed at pad_x, pad_y of the input; the rest is grey.
struct Letterbox {
  PixelRect part;
  std::size_t scaled_width = 0, scaled_height = 0, pad_x = 0, pad_y = 0;

  // Corner convention on both sides: input px <-> px of the whole image.
  [[nodiscard]] geometry::PixelBox to_image(const geometry::PixelBox& input) const;
  [[nodiscard]] geometry::PixelBox to_input(const geometry::PixelBox& image) const;
};

// part and input of positive size. The longer side fills the input, the other is centred (the odd pixel goes right or
// down) and rounded to whole pixels, at least 1.
[[nodiscard]] Letterbox letterbox(const PixelRect& part, const InputSize& input);

}  // namespace cairn::detection
