#include "fragility/polar_plot.hpp"

#include <algorithm>
#include <cmath>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::fragility {
namespace {

constexpr double kCentre = 240.0, kRadius = 170.0;  // px of the view box

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '&') out += "&amp;";
    else out += c;
  }
  return out;
}

std::string at(double azimuth_deg, double radius) {
  const double a = base::deg_to_rad(azimuth_deg);
  return base::to_fixed(kCentre + radius * std::sin(a), 2) + "," + base::to_fixed(kCentre - radius * std::cos(a), 2);
}

// 1, 2 or 5 times a power of ten, so that at most five rings fit.
double ring_step(double most) {
  double step = std::pow(10.0, std::floor(std::log10(most / 5.0)));
  for (const double factor : {1.0, 2.0, 5.0, 10.0})
    if (most / (step * factor) <= 5.0) return step * factor;
  return step * 10.0;
}

std::string label(double x, double y, std::string_view anchor, std::string_view text, int size = 12) {
  return "<text x=\"" + base::to_fixed(x, 1) + "\" y=\"" + base::to_fixed(y, 1) + "\" text-anchor=\"" +
         std::string(anchor) + "\" font-size=\"" + std::to_string(size) + "\">" + escaped(text) + "</text>\n";
}

}  // namespace

std::string polar_plot_svg(const survey::Tipping& tipping, std::string_view title) {
  const auto& values = tipping.a_qs_g_by_azimuth;
  if (values.size() != 360 || !tipping.critical ||
      !std::all_of(values.begin(), values.end(), [](double a) { return std::isfinite(a) && a > 0.0; }))
    throw base::Error(base::ErrorCode::failed_precondition, "no tipping values to plot");
  const double most = *std::max_element(values.begin(), values.end());
  const double step = ring_step(most);
  const double outer = step * std::ceil(most / step - 1e-9);

  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 480 500\" font-family=\"sans-serif\" fill=\"#222\">\n"
      "<rect width=\"480\" height=\"500\" fill=\"#fff\"/>\n";
  for (double r = step; r <= outer * (1 + 1e-9); r += step) {
    const double px = kRadius * r / outer;
    svg += "<circle cx=\"240\" cy=\"240\" r=\"" + base::to_fixed(px, 2) + "\" fill=\"none\" stroke=\"#ccc\"/>\n";
    svg += label(kCentre + 3, kCentre - px - 2, "start", base::to_text(std::round(r * 1e6) / 1e6) + " g", 10);
  }
  for (int azimuth = 0; azimuth < 360; azimuth += 45)
    svg += "<path d=\"M240,240 L" + at(azimuth, kRadius) + "\" stroke=\"#ddd\"/>\n";
  svg += label(kCentre, kCentre - kRadius - 12, "middle", "N", 14) +
         label(kCentre + kRadius + 12, 245, "start", "E", 14) +
         label(kCentre, kCentre + kRadius + 22, "middle", "S", 14) + label(kCentre - kRadius - 12, 245, "end", "W", 14);
  svg += "<path d=\"M";
  for (std::size_t k = 0; k < values.size(); ++k)
    svg += (k == 0 ? "" : " L") + at(static_cast<double>(k), kRadius * values[k] / outer);
  svg += " Z\" fill=\"#c0622f\" fill-opacity=\"0.25\" stroke=\"#c0622f\" stroke-width=\"2\"/>\n";
  const auto& edge = *tipping.critical;
  svg += "<path d=\"M240,240 L" + at(edge.azimuth_deg, kRadius) + "\" stroke=\"#8b1a1a\" stroke-dasharray=\"5 4\"/>\n";
  svg += label(kCentre, 20, "middle", title, 15);
  std::string line = "grade " + std::string(survey::name_of(tipping.grade));
  for (const auto& reason : tipping.reasons) line += ", " + reason;
  svg += label(kCentre, 462, "middle", line, 11);
  svg += label(kCentre, 482, "middle",
               "least angle " + base::to_fixed(base::rad_to_deg(edge.alpha_rad), 1) + " deg, toppling towards " +
                   base::to_fixed(edge.azimuth_deg, 0) + " deg; acceleration [g] by direction of toppling",
               11);
  return svg + "</svg>\n";
}

}  // namespace cairn::fragility
