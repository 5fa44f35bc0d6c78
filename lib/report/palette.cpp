#include "report/palette.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace cairn::report {
namespace {

using Stop = std::array<double, 3>;

Rgba ramp(std::span<const Stop> stops, double t) {
  const double x = std::clamp(t, 0.0, 1.0) * static_cast<double>(stops.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(x), stops.size() - 2);
  const double f = x - static_cast<double>(i);
  Rgba out{0, 0, 0, 255};
  for (std::size_t k = 0; k < 3; ++k)
    out[k] = static_cast<std::uint8_t>(std::lround(stops[i][k] * (1.0 - f) + stops[i + 1][k] * f));
  return out;
}

constexpr std::array<Stop, 9> kCividis{{{0, 34, 78},
                                        {18, 53, 112},
                                        {59, 73, 108},
                                        {87, 93, 109},
                                        {112, 113, 115},
                                        {138, 134, 120},
                                        {165, 156, 116},
                                        {195, 179, 105},
                                        {254, 232, 56}}};
constexpr std::array<Stop, 5> kCost{{{255, 247, 214}, {253, 204, 122}, {240, 134, 74}, {176, 63, 94}, {72, 26, 92}}};
constexpr std::array<Stop, 5> kHeight{
    {{136, 168, 164}, {178, 196, 168}, {222, 214, 178}, {236, 222, 200}, {250, 248, 244}}};

constexpr std::array<ClassStyle, 6> kFree{{{"#cc79a7", "diamond"},
                                           {"#e69f00", "pentagon"},
                                           {"#0072b2", "cross"},
                                           {"#009e73", "triangle"},
                                           {"#56b4e9", "square"},
                                           {"#d55e00", "circle"}}};

}  // namespace

Rgba cividis(double t) {
  return ramp(kCividis, t);
}
Rgba cost_ramp(double t) {
  return ramp(kCost, t);
}
Rgba height_ramp(double t) {
  return ramp(kHeight, t);
}

std::string css_colour(const Rgba& colour) {
  static constexpr std::string_view kHex = "0123456789abcdef";
  std::string out = "#";
  for (std::size_t k = 0; k < 3; ++k) {
    out += kHex[colour[k] >> 4];
    out += kHex[colour[k] & 15];
  }
  return out;
}

ClassStyle class_style(std::string_view object_class, std::size_t place) {
  if (object_class == "boulder" || object_class == "rock" || object_class == "pbr") return {"#d55e00", "circle"};
  if (object_class == "tree") return {"#009e73", "triangle"};
  if (object_class == "car" || object_class == "vehicle") return {"#56b4e9", "square"};
  if (object_class == "bench") return {"#cc79a7", "diamond"};
  if (object_class.ends_with("table")) return {"#e69f00", "pentagon"};
  return kFree[place % kFree.size()];
}

}  // namespace cairn::report
