// Colours that people with any colour vision can tell apart.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "report/png.hpp"

namespace cairn::report {

// Cividis (Nunez, Anderton, Renslow 2018), 0 <= t <= 1, dark blue to yellow, even in lightness.
[[nodiscard]] Rgba cividis(double t);
// Pale yellow over orange to deep purple, for cost; lightness falls evenly.
[[nodiscard]] Rgba cost_ramp(double t);
// Muted green over sand to white for heights; lightness rises.
[[nodiscard]] Rgba height_ramp(double t);

// "#1a2b3c"
[[nodiscard]] std::string css_colour(const Rgba& colour);

// Colour (Okabe and Ito 2008) and shape of an object class: known classes have their own, others
// take the next free one by the class's place in the sorted list of classes.
struct ClassStyle {
  std::string_view colour;  // "#d55e00"
  std::string_view shape;   // id of the map symbol: "circle", "square", "triangle", "diamond", "pentagon", "cross"
};
[[nodiscard]] ClassStyle class_style(std::string_view object_class, std::size_t place);

}  // namespace cairn::report
