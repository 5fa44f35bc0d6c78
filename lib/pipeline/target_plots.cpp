#include "pipeline/target_plots.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "base/number_text.hpp"

namespace cairn::pipeline {
namespace {

constexpr double kWidth = 640.0, kLeft = 64.0, kRight = 16.0, kPanel = 150.0;
constexpr double kFirstTop = 44.0, kSecondTop = 232.0;

struct Panel {
  double top = 0.0;              // px
  double low = 0.0, high = 1.0;  // of the values
  double last = 1.0;             // keyframe at the right edge

  [[nodiscard]] double x(double keyframe) const { return kLeft + (kWidth - kLeft - kRight) * (keyframe / last); }
  [[nodiscard]] double y(double value) const {
    return top + kPanel * (high - std::clamp(value, low, high)) / (high - low);
  }
};

std::string px(double value) {
  return base::to_fixed(value, 1);
}

std::string text(double x, double y, const std::string& anchor, const std::string& words,
                 const std::string& more = "") {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" + words +
         "</text>\n";
}

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return "<line x1=\"" + px(x1) + "\" y1=\"" + px(y1) + "\" x2=\"" + px(x2) + "\" y2=\"" + px(y2) + "\" " + style +
         "/>\n";
}

std::string escaped(const std::string& words) {
  std::string result;
  for (const char c : words) {
    if (c == '<') result += "&lt;";
    else if (c == '>') result += "&gt;";
    else if (c == '&') result += "&amp;";
    else result += c;
  }
  return result;
}

// Axes, threshold, and the curve; values[i] belongs to keyframe first + i.
std::string drawn(const Panel& panel, std::span<const double> values, double first, double threshold,
                  const std::string& threshold_text, const std::string& title, bool powers) {
  std::string svg = text(kLeft, panel.top - 6.0, "start", title, " font-weight=\"600\"");
  constexpr int kSteps = 4;
  for (int i = 0; i <= kSteps; ++i) {
    const double value = panel.low + (panel.high - panel.low) * i / kSteps;
    svg += line(kLeft, panel.y(value), kWidth - kRight, panel.y(value), "stroke=\"#e3e0da\"");
    const std::string label =
        powers ? base::to_text(std::round(100.0 * std::pow(10.0, value) / std::pow(10.0, std::floor(value))) / 100.0 *
                               std::pow(10.0, std::floor(value)))
               : base::to_fixed(value, 1);
    svg += text(kLeft - 8.0, panel.y(value) + 4.0, "end", label);
  }
  svg += line(kLeft, panel.y(threshold), kWidth - kRight, panel.y(threshold),
              "stroke=\"#a33b20\" stroke-dasharray=\"5 4\"");
  svg += text(kWidth - kRight, panel.y(threshold) - 4.0, "end", threshold_text, " fill=\"#a33b20\"");
  std::string points;
  for (std::size_t i = 0; i < values.size(); ++i)
    points += (i > 0 ? " " : "") + px(panel.x(first + static_cast<double>(i))) + "," + px(panel.y(values[i]));
  svg += "<polyline fill=\"none\" stroke=\"#22577a\" stroke-width=\"1.6\" points=\"" + points + "\"/>\n";
  if (values.size() <= 80)
    for (std::size_t i = 0; i < values.size(); ++i)
      svg += "<circle r=\"2.2\" fill=\"#22577a\" cx=\"" + px(panel.x(first + static_cast<double>(i))) + "\" cy=\"" +
             px(panel.y(values[i])) + "\"/>\n";
  return svg;
}

}  // namespace

std::string history_plot(const survey::Target& target, const PlotThresholds& thresholds) {
  const auto finite = [](std::vector<double> values) {
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    return values;
  };
  const std::vector<double> entropy = finite(target.entropy_nats);
  std::vector<double> divergence = finite(target.divergence);
  constexpr double kSmallest = 1e-4;
  for (double& d : divergence) d = std::log10(std::max(d, kSmallest));
  const double level = std::log10(std::max(thresholds.divergence, kSmallest));
  const double last = std::max<double>(1.0, static_cast<double>(std::max(entropy.size(), divergence.size() + 1)) - 1.0);

  Panel above{kFirstTop, thresholds.entropy_nats - 1.0, thresholds.entropy_nats + 1.0, last};
  for (const double h : entropy) {
    above.low = std::min(above.low, std::floor(h));
    above.high = std::max(above.high, std::ceil(h));
  }
  Panel below{kSecondTop, std::floor(level), std::ceil(level) + 1.0, last};
  for (const double d : divergence) {
    below.low = std::min(below.low, std::floor(d));
    below.high = std::max(below.high, std::ceil(d));
  }

  const std::string size = "width=\"640\" height=\"420\" viewBox=\"0 0 640 420\"";
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" " + size +
                    " font-family=\"sans-serif\" font-size=\"11\" fill=\"#2f2a24\">\n"
                    "<rect width=\"640\" height=\"420\" fill=\"#ffffff\"/>\n";
  svg += text(kLeft, 18.0, "start",
              "Target " + std::to_string(target.id.value) + " (" + escaped(target.object_class) + "), " +
                  std::string(survey::name_of(target.state)),
              " font-size=\"13\" font-weight=\"600\"");
  svg += drawn(above, entropy, 0.0, thresholds.entropy_nats,
               "converging below " + base::to_text(thresholds.entropy_nats), "differential entropy [nats]", false);
  svg += drawn(below, divergence, 1.0, level, "settled below " + base::to_text(thresholds.divergence),
               "divergence from the update before", true);
  // Stages stand at the last keyframe that was not later.
  double label = 0.0;
  for (const auto& entry : target.history) {
    double at = 0.0;
    for (std::size_t k = 0; k < target.keyframes.size() && target.keyframes[k] <= entry.frame; ++k)
      at = static_cast<double>(k);
    const double x = above.x(std::min(at, last));
    svg += line(x, kFirstTop, x, kSecondTop + kPanel, "stroke=\"#6b8f3a\" stroke-dasharray=\"2 3\"");
    const bool right = x > kWidth - 90.0;
    svg += text(x + (right ? -3.0 : 3.0), kFirstTop + 12.0 + label, right ? "end" : "start",
                std::string(survey::name_of(entry.state)), " fill=\"#4c6a25\"");
    label += 13.0;
  }
  svg += text(kLeft, kSecondTop + kPanel + 18.0, "start", "keyframe 0");
  svg += text(kWidth - kRight, kSecondTop + kPanel + 18.0, "end", "keyframe " + base::to_text(last));
  return svg + "</svg>\n";
}

}  // namespace cairn::pipeline
