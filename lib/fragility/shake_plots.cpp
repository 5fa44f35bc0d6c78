#include "fragility/shake_plots.hpp"

#include <algorithm>
#include <cmath>

#include "base/number_text.hpp"
#include "fragility/svg_text.hpp"

namespace cairn::fragility {
namespace {

// px of the view box.
constexpr double kWidth = 640.0, kHeight = 460.0, kLeft = 70.0, kRight = 610.0, kTop = 62.0, kBottom = 400.0;

std::string px(double v) {
  return base::to_fixed(v, 2);
}

std::string label(double x, double y, std::string_view anchor, std::string_view text, int size = 12,
                  std::string_view more = "") {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + std::string(anchor) + "\" font-size=\"" +
         std::to_string(size) + "\"" + std::string(more) + ">" + escaped(text) + "</text>\n";
}

std::string line(double x0, double y0, double x1, double y1, std::string_view stroke) {
  return "<line x1=\"" + px(x0) + "\" y1=\"" + px(y0) + "\" x2=\"" + px(x1) + "\" y2=\"" + px(y1) + "\" stroke=\"" +
         std::string(stroke) + "\"/>\n";
}

// A logarithmic axis between two values.
struct LogAxis {
  double lo, hi, from, to;  // values, px
  [[nodiscard]] double at(double value) const { return from + (to - from) * std::log(value / lo) / std::log(hi / lo); }
  // 1, 2, 5 times powers of ten inside.
  [[nodiscard]] std::vector<double> ticks() const {
    std::vector<double> list;
    for (int e = static_cast<int>(std::floor(std::log10(lo))); e <= static_cast<int>(std::ceil(std::log10(hi))); ++e)
      for (const double m : {1.0, 2.0, 5.0}) {
        const double v = m * std::pow(10.0, e);
        if (v >= lo * (1 - 1e-9) && v <= hi * (1 + 1e-9)) list.push_back(v);
      }
    return list;
  }
};

std::string tick_text(double v) {
  return v >= 1.0 ? base::to_fixed(v, 0)
                  : base::to_fixed(v, std::max(1, -static_cast<int>(std::floor(std::log10(v) + 1e-9))));
}

std::string head(std::string_view title, std::string_view subtitle) {
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + px(kWidth) + " " + px(kHeight) +
         "\" font-family=\"sans-serif\" fill=\"#222\">\n<rect width=\"" + px(kWidth) + "\" height=\"" + px(kHeight) +
         "\" fill=\"#fff\"/>\n" + label(kLeft, 26, "start", title, 16) +
         label(kLeft, 46, "start", subtitle, 12, " fill=\"#555\"");
}

std::string x_axis(const LogAxis& x, std::string_view name) {
  std::string svg;
  for (const double v : x.ticks()) {
    svg += line(x.at(v), kTop, x.at(v), kBottom, "#e4e4e4");
    svg += label(x.at(v), kBottom + 18, "middle", tick_text(v));
  }
  return svg + label(0.5 * (kLeft + kRight), kBottom + 42, "middle", name, 13);
}

std::string frame() {
  return "<rect x=\"" + px(kLeft) + "\" y=\"" + px(kTop) + "\" width=\"" + px(kRight - kLeft) + "\" height=\"" +
         px(kBottom - kTop) + "\" fill=\"none\" stroke=\"#888\"/>\n";
}

std::string upright(std::string_view name) {
  return label(0, 0, "middle", name, 13, " transform=\"translate(20 " + px(0.5 * (kTop + kBottom)) + ") rotate(-90)\"");
}

}  // namespace

std::string fragility_curve_svg(std::span<const CurvePoint> curve, bool banded, std::span<const ShakeOutcome> outcomes,
                                std::string_view title, std::string_view subtitle) {
  std::string svg = head(title, subtitle);
  if (curve.size() < 2) return svg + label(kLeft, kTop + 30, "start", "no curve") + "</svg>\n";
  const LogAxis x{curve.front().pga_g, curve.back().pga_g, kLeft, kRight};
  const auto y = [](double p) { return kBottom - p * (kBottom - kTop); };
  svg += x_axis(x, "PGA [g]");
  for (int k = 0; k <= 10; k += 2) {
    const double p = k / 10.0;
    svg += line(kLeft, y(p), kRight, y(p), "#e4e4e4") + label(kLeft - 8, y(p) + 4, "end", base::to_fixed(p, 1));
  }
  svg += upright("probability of overturning");
  const auto band = [&](double CurvePoint::*low, double CurvePoint::*high, std::string_view fill) {
    std::string points;
    for (const auto& c : curve) points += px(x.at(c.pga_g)) + "," + px(y(c.*low)) + " ";
    for (auto c = curve.rbegin(); c != curve.rend(); ++c) points += px(x.at(c->pga_g)) + "," + px(y((*c).*high)) + " ";
    svg += "<polygon points=\"" + points + "\" fill=\"" + std::string(fill) + "\"/>\n";
  };
  if (banded) {
    band(&CurvePoint::p05, &CurvePoint::p95, "#d5e4f3");
    band(&CurvePoint::p16, &CurvePoint::p84, "#a9c8e6");
  }
  std::string points;
  for (const auto& c : curve) points += px(x.at(c.pga_g)) + "," + px(y(c.p)) + " ";
  svg += "<polyline points=\"" + points + "\" fill=\"none\" stroke=\"#1f5fa8\" stroke-width=\"2.5\"/>\n";
  // Outcomes by step of PGA: share toppled, area by number.
  constexpr std::size_t kSteps = 16;
  std::vector<double> count(kSteps, 0.0), toppled(kSteps, 0.0);
  for (const auto& o : outcomes) {
    const double at = std::log(o.pga_g / x.lo) / std::log(x.hi / x.lo) * static_cast<double>(kSteps);
    if (!(at >= 0.0) || !(at < static_cast<double>(kSteps))) continue;
    count[static_cast<std::size_t>(at)] += 1.0;
    toppled[static_cast<std::size_t>(at)] += o.toppled ? 1.0 : 0.0;
  }
  const double most = *std::max_element(count.begin(), count.end());
  for (std::size_t k = 0; k < kSteps; ++k) {
    if (count[k] == 0.0) continue;
    const double pga = x.lo * std::pow(x.hi / x.lo, (static_cast<double>(k) + 0.5) / static_cast<double>(kSteps));
    svg += "<circle cx=\"" + px(x.at(pga)) + "\" cy=\"" + px(y(toppled[k] / count[k])) + "\" r=\"" +
           px(2.5 + 4.5 * std::sqrt(count[k] / most)) + "\" fill=\"#c8502b\" fill-opacity=\"0.7\"/>\n";
  }
  svg += frame();
  const double lx = kLeft + 14, ly = kTop + 20;
  svg += "<rect x=\"" + px(lx - 6) + "\" y=\"" + px(ly - 14) + "\" width=\"236\" height=\"" + px(banded ? 62.0 : 42.0) +
         "\" fill=\"#fff\" fill-opacity=\"0.85\"/>\n";
  svg += "<line x1=\"" + px(lx) + "\" y1=\"" + px(ly - 4) + "\" x2=\"" + px(lx + 22) + "\" y2=\"" + px(ly - 4) +
         "\" stroke=\"#1f5fa8\" stroke-width=\"2.5\"/>\n" +
         label(lx + 30, ly, "start", "logistic at PGV/PGA " + base::to_fixed(curve.front().pgv_over_pga_s, 3) + " s");
  svg += "<circle cx=\"" + px(lx + 11) + "\" cy=\"" + px(ly + 16) +
         "\" r=\"5\" fill=\"#c8502b\" fill-opacity=\"0.7\"/>\n" +
         label(lx + 30, ly + 20, "start", "runs that toppled, all PGV/PGA");
  if (banded)
    svg += "<rect x=\"" + px(lx) + "\" y=\"" + px(ly + 30) +
           "\" width=\"11\" height=\"12\" fill=\"#d5e4f3\"/>\n<rect x=\"" + px(lx + 11) + "\" y=\"" + px(ly + 30) +
           "\" width=\"11\" height=\"12\" fill=\"#a9c8e6\"/>\n" +
           label(lx + 30, ly + 40, "start", "5-95 %, 16-84 % over records");
  return svg + "</svg>\n";
}

std::string overturning_map_svg(const OverturningMap& map, const LogisticFit* fit, std::string_view title,
                                std::string_view subtitle) {
  std::string svg = head(title, subtitle);
  const std::size_t n = map.pga_g.size(), m = map.ratio_s.size();
  if (n < 2 || m < 2) return svg + label(kLeft, kTop + 30, "start", "no map") + "</svg>\n";
  // Cells reach half a step beyond the first and the last value.
  const double dx = std::pow(map.pga_g[1] / map.pga_g[0], 0.5), dy = std::pow(map.ratio_s[1] / map.ratio_s[0], 0.5);
  const LogAxis x{map.pga_g.front() / dx, map.pga_g.back() * dx, kLeft, kRight - 50};
  const LogAxis y{map.ratio_s.front() / dy, map.ratio_s.back() * dy, kBottom, kTop};
  const auto colour = [](double share) {
    const auto mix = [share](double a, double b) {
      return std::to_string(static_cast<int>(std::lround(a + share * (b - a))));
    };
    return "rgb(" + mix(244, 158) + "," + mix(243, 38) + "," + mix(238, 22) + ")";
  };
  for (std::size_t r = 0; r < m; ++r)
    for (std::size_t k = 0; k < n;) {
      // Cells of one value in a row are one rectangle.
      std::size_t end = k + 1;
      const double share = map.share[r * n + k];
      while (end < n && map.share[r * n + end] == share) ++end;
      const double x0 = x.at(map.pga_g[k] / dx), x1 = x.at(map.pga_g[end - 1] * dx);
      const double y0 = y.at(map.ratio_s[r] * dy), y1 = y.at(map.ratio_s[r] / dy);
      svg += "<rect x=\"" + px(x0) + "\" y=\"" + px(y0) + "\" width=\"" + px(x1 - x0 + 0.3) + "\" height=\"" +
             px(y1 - y0 + 0.3) + "\" fill=\"" + colour(share) + "\"/>\n";
      k = end;
    }
  for (const double v : x.ticks())
    svg += label(x.at(v), kBottom + 18, "middle", tick_text(v)) + line(x.at(v), kBottom, x.at(v), kBottom + 5, "#888");
  for (const double v : y.ticks())
    svg += label(kLeft - 9, y.at(v) + 4, "end", tick_text(v)) + line(kLeft - 5, y.at(v), kLeft, y.at(v), "#888");
  svg += label(0.5 * (kLeft + kRight - 50), kBottom + 42, "middle", "PGA [g]", 13) + upright("PGV/PGA [s]");
  if (fit != nullptr && fit->fitted && fit->b[1] > 0.0) {
    std::string points;
    for (const double ratio : map.ratio_s) {
      const double pga = fit->median_pga_g(ratio);
      if (pga >= x.lo && pga <= x.hi) points += px(x.at(pga)) + "," + px(y.at(ratio)) + " ";
    }
    if (!points.empty())
      svg += "<polyline points=\"" + points +
             "\" fill=\"none\" stroke=\"#1f5fa8\" stroke-width=\"2.5\" stroke-dasharray=\"7 4\"/>\n" +
             label(kRight - 52, kTop - 4, "end", "dashed: median of the records' logistic", 11, " fill=\"#1f5fa8\"");
  }
  svg += "<rect x=\"" + px(kLeft) + "\" y=\"" + px(kTop) + "\" width=\"" + px(kRight - 50 - kLeft) + "\" height=\"" +
         px(kBottom - kTop) + "\" fill=\"none\" stroke=\"#888\"/>\n";
  for (int k = 0; k <= 4; ++k) {
    const double top = kTop + 26 + 22.0 * (4 - k);
    svg += "<rect x=\"" + px(kRight - 38) + "\" y=\"" + px(top) + "\" width=\"16\" height=\"22\" fill=\"" +
           colour(k / 4.0) + "\" stroke=\"#bbb\"/>\n" +
           label(kRight - 16, top + 15, "start", base::to_fixed(k / 4.0, 2), 11);
  }
  svg +=
      label(kRight - 38, kTop + 6, "start", "share that", 11) + label(kRight - 38, kTop + 18, "start", "overturns", 11);
  return svg + "</svg>\n";
}

}  // namespace cairn::fragility
