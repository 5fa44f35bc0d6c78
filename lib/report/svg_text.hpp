// Pieces of SVG text that the figures share.
#pragma once

#include <string>
#include <string_view>

#include "geometry/vec.hpp"

namespace cairn::report::svg {

// One decimal.
[[nodiscard]] std::string px(double value);
[[nodiscard]] std::string at(const geometry::Vec2& p);  // "x,y"
// Head with a white ground; close with "</svg>\n".
[[nodiscard]] std::string open(double width, double height);
// `anchor`: start, middle, end. Text is escaped.
[[nodiscard]] std::string text(double x, double y, std::string_view anchor, std::string_view content, int size = 12,
                               std::string_view colour = "#222");
[[nodiscard]] std::string line(const geometry::Vec2& a, const geometry::Vec2& b, std::string_view style);
[[nodiscard]] std::string dot(const geometry::Vec2& p, double radius, std::string_view style);
// A bar of a round length (1, 2 or 5 times a power of ten metres) at most `most_px` long, its length under it.
[[nodiscard]] std::string scale_bar(double x, double y, double px_per_m, double most_px);

}  // namespace cairn::report::svg
