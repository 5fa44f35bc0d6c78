#include "report/outcome_plane.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/number_text.hpp"
#include "report/html_text.hpp"

namespace cairn::report {
namespace {

constexpr double kLeft = 70.0, kRight = 500.0, kTop = 50.0, kBottom = 350.0;

struct Axis {
  double low = 0.1, high = 1.0, from = 0.0, to = 1.0;
  [[nodiscard]] double at(double value) const {
    return from + (to - from) * std::log(value / low) / std::log(high / low);
  }
};

std::string px(double v) {
  return base::to_fixed(v, 1);
}

std::string text(double x, double y, const char* anchor, std::string_view content, int size = 12,
                 const std::string& more = {}) {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\" font-size=\"" +
         std::to_string(size) + "\"" + more + ">" + escape_html(content) + "</text>\n";
}

// 1, 2, 5 times powers of ten inside the axis.
std::vector<double> ticks(const Axis& axis) {
  std::vector<double> values;
  for (int e = -4; e <= 3; ++e)
    for (const double m : {1.0, 2.0, 5.0}) {
      const double v = m * std::pow(10.0, e);
      if (v >= axis.low * 0.999 && v <= axis.high * 1.001) values.push_back(v);
    }
  return values;
}

std::string mark_svg(const PlaneMark& m, double x, double y) {
  const char* colour = m.toppled ? "#8b1a1a" : "#2f6f4f";
  std::string svg = "<circle cx=\"" + px(x) + "\" cy=\"" + px(y) + "\" r=\"6\" stroke=\"" + colour +
                    "\" stroke-width=\"2\" fill=\"" + (m.toppled ? colour : "#fff") + "\"/>\n";
  if (m.toppled_plane && *m.toppled_plane != m.toppled)
    svg += "<path d=\"M" + px(x - 9) + "," + px(y - 9) + " L" + px(x + 9) + "," + px(y + 9) + " M" + px(x - 9) + "," +
           px(y + 9) + " L" + px(x + 9) + "," + px(y - 9) + "\" stroke=\"#222\" stroke-width=\"1.5\"/>\n";
  return svg;
}

}  // namespace

std::string outcome_plane_svg(std::span<const PlaneMark> marks, double a_qs_g, std::string_view title) {
  Axis x{0.05, 0.5, kLeft, kRight}, y{0.5 * a_qs_g, 5.0 * a_qs_g, kBottom, kTop};
  for (const auto& m : marks) {
    x.low = std::min(x.low, m.pgv_over_pga_s * 0.8);
    x.high = std::max(x.high, m.pgv_over_pga_s * 1.25);
    y.low = std::min(y.low, m.pga_g * 0.8);
    y.high = std::max(y.high, m.pga_g * 1.25);
  }
  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 540 450\" font-family=\"sans-serif\" fill=\"#222\">\n"
      "<rect width=\"540\" height=\"450\" fill=\"#fff\"/>\n";
  for (const double v : ticks(x)) {
    svg += "<path d=\"M" + px(x.at(v)) + "," + px(kTop) + " V" + px(kBottom) + "\" stroke=\"#ddd\"/>\n";
    svg += text(x.at(v), kBottom + 16, "middle", base::to_text(v), 11);
  }
  for (const double v : ticks(y)) {
    svg += "<path d=\"M" + px(kLeft) + "," + px(y.at(v)) + " H" + px(kRight) + "\" stroke=\"#ddd\"/>\n";
    svg += text(kLeft - 6, y.at(v) + 4, "end", base::to_text(v), 11);
  }
  svg += "<path d=\"M" + px(kLeft) + "," + px(y.at(a_qs_g)) + " H" + px(kRight) +
         "\" stroke=\"#555\" stroke-dasharray=\"6 4\"/>\n";
  svg += text(kRight - 4, y.at(a_qs_g) + 13, "end", "quasi-static " + base::to_fixed(a_qs_g, 3) + " g", 11);
  for (const auto& m : marks) svg += mark_svg(m, x.at(m.pgv_over_pga_s), y.at(m.pga_g));
  svg += text(0.5 * (kLeft + kRight), 24, "middle", title, 15);
  svg += text(0.5 * (kLeft + kRight), kBottom + 36, "middle", "PGV/PGA [s]");
  svg += text(18, 0.5 * (kTop + kBottom), "middle", "PGA [g]", 12,
              " transform=\"rotate(-90 18 " + px(0.5 * (kTop + kBottom)) + ")\"");
  svg += mark_svg({1, 1, true, {}}, kLeft + 6, 410) + text(kLeft + 18, 414, "start", "toppled in three dimensions", 11);
  svg += mark_svg({1, 1, false, {}}, kLeft + 196, 410) + text(kLeft + 208, 414, "start", "stood", 11);
  svg +=
      mark_svg({1, 1, false, true}, kLeft + 266, 410) + text(kLeft + 280, 414, "start", "the plane model differs", 11);
  return svg + "</svg>\n";
}

}  // namespace cairn::report
