#include "report/charts.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "base/angle.hpp"
#include "base/number_text.hpp"

namespace cairn::report {
namespace {

std::string num(double value, int decimals = 2) {
  return Html::short_number(value, decimals);
}

std::string percent(double fraction) {
  return num(100.0 * fraction, 1) + "\u202f%";
}

}  // namespace

double nice_ceiling(double value) {
  if (!(value > 0.0) || !std::isfinite(value)) return 1.0;
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double step : {1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0})
    if (step * power >= value * (1.0 - 1e-9)) return step * power;
  return 10.0 * power;
}

Html polar_chart(std::span<const double> values, double critical_deg) {
  constexpr double kRadius = 92.0;
  double least = std::numeric_limits<double>::infinity(), top = 0.0;
  for (const double v : values)
    if (std::isfinite(v)) least = std::min(least, v);
  for (const double v : values)
    if (std::isfinite(v) && v <= 8.0 * least) top = std::max(top, v);
  const double limit = nice_ceiling(top);
  const auto point = [&](double value, double degrees) {
    const double r = kRadius * (std::isfinite(value) ? std::min(value / limit, 1.0) : 1.0);
    const double a = base::deg_to_rad(degrees);
    return num(r * std::sin(a)) + " " + num(-r * std::cos(a));
  };
  Html h;
  h.raw("<svg class=\"polar\" viewBox=\"-122 -116 244 232\" role=\"img\"")
      .attr("aria-label", "Polar diagram of the quasi-static tipping acceleration by azimuth; least " + num(least, 3) +
                              " g toward " + num(critical_deg, 0) + " degrees")
      .attr("data-limit", limit, 6)
      .raw(">");
  for (int ring = 1; ring <= 4; ++ring) {
    h.raw("<circle class=\"grid\"").attr("r", kRadius * ring / 4.0).raw("/>");
    if (ring % 2 == 0)
      h.raw("<text class=\"ring\"")
          .attr("x", 2.0)
          .attr("y", -kRadius * ring / 4.0 - 2.0)
          .raw(">")
          .text(num(limit * ring / 4.0, 4) + (ring == 4 ? "\u202fg" : ""))
          .raw("</text>");
  }
  for (int a = 0; a < 360; a += 30) {
    const double s = std::sin(base::deg_to_rad(a)), c = std::cos(base::deg_to_rad(a));
    h.raw("<line class=\"grid\" x1=\"0\" y1=\"0\"").attr("x2", kRadius * s).attr("y2", -kRadius * c).raw("/>");
    if (a == 0) continue;
    h.raw("<text class=\"azimuth\"").attr("x", (kRadius + 13.0) * s).attr("y", -(kRadius + 13.0) * c + 3.0).raw(">");
    if (a % 90 == 0) h.text(a == 90 ? "E" : a == 180 ? "S" : "W");
    else h.text(std::to_string(a) + "°");
    h.raw("</text>");
  }
  h.raw("<text class=\"azimuth north\" x=\"0\"").attr("y", -kRadius - 9.0).raw(">N</text>");
  std::string path;
  for (std::size_t a = 0; a < values.size(); ++a)
    path += (a == 0 ? "M" : "L") + point(values[a], static_cast<double>(a));
  h.raw("<path class=\"curve\"").attr("d", path + "Z").raw("/>");
  const double s = std::sin(base::deg_to_rad(critical_deg)), c = std::cos(base::deg_to_rad(critical_deg));
  h.raw("<line class=\"critical\" x1=\"0\" y1=\"0\"").attr("x2", kRadius * s).attr("y2", -kRadius * c).raw("/>");
  h.raw("<path class=\"critical-tip\" d=\"M0 -8L4.5 3L-4.5 3Z\"")
      .attr("transform",
            "translate(" + num(kRadius * s) + " " + num(-kRadius * c) + ") rotate(" + num(critical_deg, 1) + ")")
      .raw("/><g class=\"readout\"></g></svg>");
  return h;
}

Html histogram_chart(const Histogram& histogram) {
  constexpr double kLeft = 40.0, kTop = 14.0, kWidth = 300.0, kHeight = 110.0;
  double total = 0.0, peak = 0.0;
  for (const double a : histogram.areas_m2) total += a;
  for (const double a : histogram.areas_m2) peak = std::max(peak, a);
  const double limit = total > 0.0 ? nice_ceiling(peak / total) : 1.0;
  const double lo = histogram.edges.front(), hi = histogram.edges.back();
  const auto x = [&](double v) { return kLeft + kWidth * (v - lo) / (hi - lo); };
  Html h;
  h.raw("<svg class=\"histogram\" viewBox=\"0 0 352 162\" role=\"img\"")
      .attr("aria-label", "Histogram: share of the area by " + histogram.title)
      .raw(">");
  for (int i = 0; i <= 2; ++i) {
    const double y = kTop + kHeight * (1.0 - i / 2.0);
    h.raw("<line class=\"grid\"").attr("x1", kLeft).attr("x2", kLeft + kWidth).attr("y1", y).attr("y2", y).raw("/>");
    h.raw("<text class=\"tick end\"")
        .attr("x", kLeft - 6.0)
        .attr("y", y + 3.5)
        .raw(">")
        .text(percent(limit * i / 2.0))
        .raw("</text>");
  }
  for (std::size_t i = 0; i < histogram.areas_m2.size(); ++i) {
    const double share = total > 0.0 ? histogram.areas_m2[i] / total : 0.0;
    const double from = histogram.edges[i], to = histogram.edges[i + 1];
    const double middle = 0.5 * (from + to);
    const bool fails =
        histogram.gate && (histogram.gate_is_minimum ? middle < *histogram.gate : middle > *histogram.gate);
    const double height = kHeight * std::min(share / limit, 1.0);
    const double gap = std::min(1.5, 0.12 * (x(to) - x(from)));
    h.raw("<rect")
        .attr("class", fails ? "bar fails" : "bar")
        .attr("x", x(from) + gap / 2)
        .attr("width", std::max(0.5, x(to) - x(from) - gap))
        .attr("y", kTop + kHeight - height)
        .attr("height", height)
        .raw("><title>");
    const std::string unit = histogram.unit.empty() ? "" : "\u202f" + histogram.unit;
    h.text(num(from) + " to " + num(to) + unit + ": " + percent(share) + " of the area, " +
           num(histogram.areas_m2[i], 1) + "\u202fm²")
        .raw("</title></rect>");
  }
  h.raw("<line class=\"axis\"")
      .attr("x1", kLeft)
      .attr("x2", kLeft + kWidth)
      .attr("y1", kTop + kHeight)
      .attr("y2", kTop + kHeight)
      .raw("/>");
  const std::size_t bins = histogram.areas_m2.size();
  const std::size_t every = std::max<std::size_t>(1, (bins + 7) / 8);
  for (std::size_t i = 0; i <= bins; i += every)
    h.raw("<text class=\"tick mid\"")
        .attr("x", x(histogram.edges[i]))
        .attr("y", kTop + kHeight + 15.0)
        .raw(">")
        .text(num(histogram.edges[i]))
        .raw("</text>");
  h.raw("<text class=\"label mid\"").attr("x", kLeft + kWidth / 2).attr("y", 158.0).raw(">");
  h.text(histogram.title + (histogram.unit.empty() ? "" : " [" + histogram.unit + "]")).raw("</text>");
  if (histogram.gate && *histogram.gate >= lo && *histogram.gate <= hi) {
    const double g = x(*histogram.gate);
    const bool right_half = g > kLeft + kWidth / 2;
    h.raw("<line class=\"gate\"")
        .attr("x1", g)
        .attr("x2", g)
        .attr("y1", kTop - 8.0)
        .attr("y2", kTop + kHeight)
        .raw("/>");
    h.raw("<text")
        .attr("class", right_half ? "gate-label end" : "gate-label")
        .attr("x", g + (right_half ? -5.0 : 5.0))
        .attr("y", kTop - 1.0)
        .raw(">")
        .text(std::string("gate ") + (histogram.gate_is_minimum ? "≥ " : "≤ ") + num(*histogram.gate))
        .raw("</text>");
  }
  h.raw("</svg>");
  return h;
}

Html spark_line(std::span<const double> values, std::string_view label) {
  Html h;
  if (values.size() < 2) return h;
  const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
  const double span = std::max(*hi - *lo, 1e-12);
  std::string path;
  for (std::size_t i = 0; i < values.size(); ++i) {
    path += i == 0 ? "M" : "L";
    path += num(2.0 + 96.0 * static_cast<double>(i) / static_cast<double>(values.size() - 1)) + " ";
    path += num(22.0 - 18.0 * (values[i] - *lo) / span);
  }
  h.raw("<svg class=\"spark\" viewBox=\"0 0 100 26\" role=\"img\"").attr("aria-label", label).raw("><path");
  h.attr("d", path).raw("/></svg>");
  return h;
}

}  // namespace cairn::report
