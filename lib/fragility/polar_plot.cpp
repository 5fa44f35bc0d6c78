#include "fragility/polar_plot.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "fragility/svg_text.hpp"

namespace cairn::fragility {
namespace {

constexpr double kCentre = 240.0, kRadius = 160.0;  // px of the view box
using Table = std::vector<double>;

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

bool complete(const Table& values) {
  return values.size() == 360 &&
         std::all_of(values.begin(), values.end(), [](double a) { return std::isfinite(a) && a > 0.0; });
}

// Closed curve; the other way round where it is to be cut out of another.
std::string curve(const Table& values, double outer, bool backwards = false) {
  std::string path = "M";
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t k = backwards ? values.size() - 1 - i : i;
    path += (i == 0 ? "" : " L") + at(static_cast<double>(k), kRadius * std::min(1.0, values[k] / outer));
  }
  return path + " Z";
}

std::string band(const Table& inner, const Table& outside, double outer, std::string_view style) {
  return "<path d=\"" + curve(outside, outer) + " " + curve(inner, outer, true) + "\" " + std::string(style) + "/>\n";
}

// Share of draws whose critical direction lies in each sector of 10 deg, as wedges outside the rim.
std::string rose(const Table& shares) {
  std::string svg;
  const double most = shares.empty() ? 0.0 : *std::max_element(shares.begin(), shares.end());
  if (shares.size() != 36 || !(most > 0.0)) return svg;
  constexpr double kFoot = kRadius + 3.0, kHeight = 22.0;
  for (std::size_t k = 0; k < 36; ++k) {
    if (!(shares[k] > 0.0)) continue;
    const double from = 10.0 * static_cast<double>(k) + 0.5, to = from + 9.0;
    const double top = kFoot + kHeight * shares[k] / most;
    svg += "<path d=\"M" + at(from, kFoot) + " L" + at(from, top) + " L" + at(to, top) + " L" + at(to, kFoot) +
           " Z\" fill=\"#8b1a1a\" fill-opacity=\"0.75\"/>\n";
  }
  return svg;
}

std::string degrees(double rad) {
  return base::to_fixed(base::rad_to_deg(rad), 1);
}

std::string interval_text(const survey::Tipping& t) {
  if (!t.outer || !t.outer->critical) return "";
  if (t.inner && t.inner->critical)
    return "contact bounds " + degrees(t.inner->critical->alpha_rad) + " to " + degrees(t.outer->critical->alpha_rad) +
           " deg";
  std::string why = t.inner ? t.inner->reason : "";
  std::replace(why.begin(), why.end(), '_', ' ');
  return "at most " + degrees(t.outer->critical->alpha_rad) + " deg; no lower bound" + (why.empty() ? "" : ": " + why);
}

std::string legend(double x, std::string_view style, std::string_view text) {
  return "<rect x=\"" + base::to_fixed(x, 0) + "\" y=\"447\" width=\"14\" height=\"10\" " + std::string(style) +
         "/>\n<text x=\"" + base::to_fixed(x + 19, 0) + "\" y=\"456\" font-size=\"11\">" + escaped(text) + "</text>\n";
}

constexpr std::string_view kBoundsStyle =
    "fill=\"#3b6ea5\" fill-opacity=\"0.22\" stroke=\"#3b6ea5\" stroke-width=\"0.8\"";
constexpr std::string_view kDrawsStyle = "fill=\"#c0622f\" fill-opacity=\"0.35\" stroke=\"none\"";
constexpr std::string_view kRimStyle = "fill=\"none\" stroke=\"#8a3f14\" stroke-width=\"2\"";

}  // namespace

std::string polar_plot_svg(const survey::Tipping& tipping, std::string_view title, std::string_view north) {
  const Table& values = tipping.a_qs_g_by_azimuth;
  if (!complete(values) || !tipping.critical)
    throw base::Error(base::ErrorCode::failed_precondition, "no tipping values to plot");
  const bool bounds = tipping.inner && tipping.outer && complete(tipping.inner->a_qs_g_by_azimuth) &&
                      complete(tipping.outer->a_qs_g_by_azimuth);
  const auto* draws = tipping.uncertainty ? &*tipping.uncertainty : nullptr;
  const bool drawn = draws != nullptr && complete(draws->a_qs_g_by_azimuth[0]) && complete(draws->a_qs_g_by_azimuth[4]);
  double most = *std::max_element(values.begin(), values.end());
  if (drawn) {
    const auto& high = draws->a_qs_g_by_azimuth[4];
    most = std::max(most, std::min(2.0 * most, *std::max_element(high.begin(), high.end())));
  }
  const double step = ring_step(most);
  const double outer = step * std::ceil(most / step - 1e-9);

  std::string svg =
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 480 520\" font-family=\"sans-serif\" fill=\"#222\">\n"
      "<rect width=\"480\" height=\"520\" fill=\"#fff\"/>\n";
  for (int azimuth = 0; azimuth < 360; azimuth += 30)
    svg += "<path d=\"M240,240 L" + at(azimuth, kRadius) + "\" stroke=\"#e4e4e4\"/>\n";
  std::string labels;
  for (double r = step; r <= outer * (1 + 1e-9); r += step) {
    const double px = kRadius * r / outer;
    svg += "<circle cx=\"240\" cy=\"240\" r=\"" + base::to_fixed(px, 2) + "\" fill=\"none\" stroke=\"#ccc\"/>\n";
    labels += label(kCentre + 3, kCentre - px + 11, "start", base::to_text(std::round(r * 1e6) / 1e6) + " g", 10);
  }
  if (bounds) svg += band(tipping.inner->a_qs_g_by_azimuth, tipping.outer->a_qs_g_by_azimuth, outer, kBoundsStyle);
  if (drawn) svg += band(draws->a_qs_g_by_azimuth[0], draws->a_qs_g_by_azimuth[4], outer, kDrawsStyle);
  svg += "<path d=\"" + curve(values, outer) + "\" " + std::string(kRimStyle) + "/>\n";
  if (draws != nullptr) svg += rose(draws->rose);
  const auto& edge = *tipping.critical;
  svg += "<path d=\"M240,240 L" + at(edge.azimuth_deg, kRadius) +
         "\" stroke=\"#8b1a1a\" stroke-width=\"1.5\" stroke-dasharray=\"5 4\"/>\n";
  svg += labels;
  constexpr double kOut = kRadius + 32.0;
  svg += label(kCentre, kCentre - kOut, "middle", "N", 14) + label(kCentre + kOut, 245, "middle", "E", 14) +
         label(kCentre, kCentre + kOut + 9, "middle", "S", 14) + label(kCentre - kOut, 245, "middle", "W", 14);
  // North arrow, and what north is.
  svg += "<path d=\"M438,78 L438,46 M438,40 L433,52 L443,52 Z\" stroke=\"#222\" fill=\"#222\"/>\n" +
         label(438, 92, "middle", north, 10);
  svg += label(kCentre, 22, "middle", title, 15);
  if (bounds) svg += legend(20, kBoundsStyle, "bounds of the contact");
  if (drawn) svg += legend(175, kDrawsStyle, "5-95 % of the draws");
  svg += legend(318, kRimStyle, "on the visible rim");
  std::string line =
      "least angle " + degrees(edge.alpha_rad) + " deg toward " + base::to_fixed(edge.azimuth_deg, 0) + " deg";
  if (draws != nullptr)
    if (const auto* q = draws->find("alpha_min_deg"))
      line += " (90 %: " + base::to_fixed(q->p05, 1) + " to " + base::to_fixed(q->p95, 1) + ")";
  if (const auto text = interval_text(tipping); !text.empty()) line += "; " + text;
  svg += label(kCentre, 478, "middle", line, 11);
  svg += label(kCentre, 494, "middle",
               "distance from the middle: acceleration [g] that tips the rock in that direction", 10);
  line = "grade " + std::string(survey::name_of(tipping.grade));
  for (const auto& reason : tipping.reasons) line += ", " + reason;
  svg += label(kCentre, 510, "middle", line, 10);
  return svg + "</svg>\n";
}

}  // namespace cairn::fragility
