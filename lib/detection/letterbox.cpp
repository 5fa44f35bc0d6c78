#include "detection/letterbox.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::detection {
namespace {

double real(std::size_t value) {
  return static_cast<double>(value);
}

std::size_t scaled(std::size_t side, double scale, std::size_t most) {
  return std::clamp(static_cast<std::size_t>(std::llround(real(side) * scale)), std::size_t{1}, most);
}

}  // namespace

geometry::PixelBox Letterbox::to_image(const geometry::PixelBox& b) const {
  const double sx = real(part.width) / real(scaled_width), sy = real(part.height) / real(scaled_height);
  const auto x = [&](double u) { return real(part.x) + (u - real(pad_x)) * sx; };
  const auto y = [&](double v) { return real(part.y) + (v - real(pad_y)) * sy; };
  return {x(b.xmin), y(b.ymin), x(b.xmax), y(b.ymax)};
}

geometry::PixelBox Letterbox::to_input(const geometry::PixelBox& b) const {
  const double sx = real(scaled_width) / real(part.width), sy = real(scaled_height) / real(part.height);
  const auto u = [&](double x) { return (x - real(part.x)) * sx + real(pad_x); };
  const auto v = [&](double y) { return (y - real(part.y)) * sy + real(pad_y); };
  return {u(b.xmin), v(b.ymin), u(b.xmax), v(b.ymax)};
}

Letterbox letterbox(const PixelRect& part, const InputSize& input) {
  const double scale = std::min(real(input.width) / real(part.width), real(input.height) / real(part.height));
  Letterbox result;
  result.part = part;
  result.scaled_width = scaled(part.width, scale, input.width);
  result.scaled_height = scaled(part.height, scale, input.height);
  result.pad_x = (input.width - result.scaled_width) / 2;
  result.pad_y = (input.height - result.scaled_height) / 2;
  return result;
}

}  // namespace cairn::detection
