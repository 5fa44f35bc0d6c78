#include "report/rock_figures.hpp"

#include <algorithm>
#include <cmath>

#include "base/number_text.hpp"
#include "report/base64.hpp"
#include "report/svg_text.hpp"

namespace cairn::report {
namespace {

// Four significant digits: what a picture can use.
std::string short_text(double value) {
  if (value == 0.0 || !std::isfinite(value)) return base::to_text(value);
  const double unit = std::pow(10.0, 3.0 - std::floor(std::log10(std::abs(value))));
  return base::to_text(std::round(value * unit) / unit);
}

}  // namespace

std::string uncertainty_svg(const survey::Rock& rock, std::string_view title) {
  if (!rock.tipping.uncertainty || rock.tipping.uncertainty->variance_shares.empty()) return {};
  const auto& u = *rock.tipping.uncertainty;
  auto shares = u.variance_shares;
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.value > b.value; });
  constexpr double kRow = 24.0, kLeft = 150.0, kBar = 300.0, kColumn = 560.0;
  const double rows = static_cast<double>(std::max(shares.size(), u.inputs.size()));
  std::string out = svg::open(820, 150 + kRow * rows);
  out += svg::text(410, 26, "middle", title, 16);
  out += svg::text(kLeft, 54, "start", "Share of the variance of the least angle", 12);
  out += svg::text(kColumn, 54, "start", "Drawn from", 12);
  double y = 64;
  for (const auto& share : shares) {
    const double width = kBar * std::clamp(share.value, 0.0, 1.0);
    out += svg::text(kLeft - 8, y + 15, "end", share.name);
    out += "<rect x=\"" + svg::px(kLeft) + "\" y=\"" + svg::px(y + 3) + "\" width=\"" + svg::px(std::max(width, 1.0)) +
           "\" height=\"16\" fill=\"#c0622f\"/>\n";
    out += svg::text(kLeft + width + 6, y + 15, "start", base::to_fixed(100.0 * share.value, 1) + " %", 11);
    y += kRow;
  }
  y = 64;
  for (const auto& input : u.inputs) {
    out += svg::text(kColumn, y + 15, "start", input.name + " = " + short_text(input.value), 11);
    y += kRow;
  }
  y = 64 + kRow * rows + 30;
  if (const auto* alpha = u.find("alpha_min_deg"))
    out += svg::text(20, y, "start",
                     "least angle: 5 % " + base::to_fixed(alpha->p05, 1) + "\u00b0, 16 % " +
                         base::to_fixed(alpha->p16, 1) + "\u00b0, median " + base::to_fixed(alpha->p50, 1) +
                         "\u00b0, 84 % " + base::to_fixed(alpha->p84, 1) + "\u00b0, 95 % " +
                         base::to_fixed(alpha->p95, 1) + "\u00b0",
                     12);
  out += svg::text(20, y + 22, "start",
                   std::to_string(u.standing) + " of " + std::to_string(u.draws) +
                       " draws stand; shares need not add up to 100 %: causes act together",
                   11);
  return out + "</svg>\n";
}

std::string photo_svg(std::string_view jpeg, double width_px, double height_px, const std::vector<PhotoLine>& lines,
                      std::string_view title) {
  constexpr double kHead = 28.0, kFoot = 26.0;
  std::string out = svg::open(width_px, height_px + kHead + kFoot);
  out += svg::text(0.5 * width_px, 19, "middle", title, 13);
  out += "<image x=\"0\" y=\"" + svg::px(kHead) + "\" width=\"" + svg::px(width_px) + "\" height=\"" +
         svg::px(height_px) + "\" href=\"data:image/jpeg;base64," + base64(jpeg) + "\"/>\n";
  for (const auto& line : lines) {
    if (line.points.size() < 2) continue;
    std::string path;
    for (const auto& p : line.points) path += (path.empty() ? "M" : " L") + svg::at({p.x(), p.y() + kHead});
    const std::string dash = line.observed ? "" : " stroke-dasharray=\"6 4\"";
    const std::string opacity = line.visible ? "" : " stroke-opacity=\"0.65\"";
    out += "<path d=\"" + path + "\" fill=\"none\" stroke=\"#000\" stroke-width=\"" + (line.visible ? "4" : "2.4") +
           "\" stroke-opacity=\"0.5\"" + dash + "/>\n";
    out += "<path d=\"" + path + "\" fill=\"none\" stroke=\"#ffd23f\" stroke-width=\"" + (line.visible ? "2.2" : "1") +
           "\"" + opacity + dash + "/>\n";
  }
  out += svg::text(8, height_px + kHead + 17, "start",
                   "contact line: thick in sight, thin behind the rock, dashed inferred", 11);
  return out + "</svg>\n";
}

}  // namespace cairn::report
