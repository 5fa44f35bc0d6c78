#include "report/svg_text.hpp"

#include <cmath>

#include "base/number_text.hpp"
#include "report/html_text.hpp"

namespace cairn::report::svg {

std::string px(double value) {
  return base::to_fixed(value, 1);
}

std::string at(const geometry::Vec2& p) {
  return px(p.x()) + "," + px(p.y());
}

std::string open(double width, double height) {
  const std::string size = "width=\"" + px(width) + "\" height=\"" + px(height) + "\"";
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + px(width) + " " + px(height) + "\" " + size +
         " font-family=\"sans-serif\" fill=\"#222\">\n<rect " + size + " fill=\"#fff\"/>\n";
}

std::string text(double x, double y, std::string_view anchor, std::string_view content, int size,
                 std::string_view colour) {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + std::string(anchor) + "\" font-size=\"" +
         std::to_string(size) + "\" fill=\"" + std::string(colour) + "\">" + escape_html(content) + "</text>\n";
}

std::string line(const geometry::Vec2& a, const geometry::Vec2& b, std::string_view style) {
  return "<path d=\"M" + at(a) + " L" + at(b) + "\" fill=\"none\" " + std::string(style) + "/>\n";
}

std::string dot(const geometry::Vec2& p, double radius, std::string_view style) {
  return "<circle cx=\"" + px(p.x()) + "\" cy=\"" + px(p.y()) + "\" r=\"" + px(radius) + "\" " + std::string(style) +
         "/>\n";
}

std::string scale_bar(double x, double y, double px_per_m, double most_px) {
  const double most = most_px / px_per_m;
  const double decade = std::pow(10.0, std::floor(std::log10(most)));
  const double length = decade * (most >= 5.0 * decade ? 5.0 : most >= 2.0 * decade ? 2.0 : 1.0);
  const double end = x + length * px_per_m;
  return "<path d=\"M" + px(x) + "," + px(y - 4) + " V" + px(y) + " H" + px(end) + " V" + px(y - 4) +
         "\" fill=\"none\" stroke=\"#222\"/>\n" +
         text(0.5 * (x + end), y + 14, "middle", base::to_text(length) + " m", 11);
}

}  // namespace cairn::report::svg
