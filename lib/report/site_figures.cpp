#include "report/site_figures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "report/charts.hpp"
#include "report/definitions.hpp"

namespace cairn::report {
namespace {

using geometry::Vec2;
using survey::Grade;

constexpr std::array kGrades{Grade::measured, Grade::bounded, Grade::screening, Grade::not_measurable};

std::string num(double v, int decimals = 2) {
  return Html::short_number(v, decimals);
}

void open(Html& h, double width, double height, const std::string& label) {
  h.raw("<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\"")
      .attr("viewBox", "0 0 " + num(width) + " " + num(height))
      .attr("aria-label", label)
      .raw(
          " font-family=\"system-ui, 'Noto Sans', 'DejaVu Sans', sans-serif\">"
          "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>");
}

void label(Html& h, double x, double y, const char* anchor, double size, std::string_view text) {
  h.raw("<text fill=\"#333333\"").attr("x", x).attr("y", y).attr("text-anchor", anchor).attr("font-size", size);
  h.raw(">").text(text).raw("</text>");
}

void line(Html& h, double x1, double y1, double x2, double y2, const char* colour, double width) {
  h.raw("<line").attr("x1", x1).attr("y1", y1).attr("x2", x2).attr("y2", y2);
  h.attr("stroke", colour).attr("stroke-width", width).raw("/>");
}

// Whole numbers for the axis of counts.
std::size_t count_step(std::size_t top) {
  for (std::size_t power = 1;; power *= 10)
    for (const std::size_t step : {std::size_t{1}, std::size_t{2}, std::size_t{5}})
      if (step * power * 5 >= top) return step * power;
}

}  // namespace

Html grade_histogram(const std::vector<SiteRock>& rocks) {
  constexpr double kBin_deg = 5.0, kLeft = 40.0, kTop = 30.0, kWidth = 480.0, kHeight = 150.0, kRight = 90.0;
  Html h;
  double greatest = 0.0;
  std::size_t shown = 0;
  for (const auto& r : rocks) {
    if (r.rejected) continue;
    ++shown;
    if (r.alpha_deg) greatest = std::max(greatest, *r.alpha_deg);
  }
  if (shown == 0) return h;
  const auto bins = static_cast<std::size_t>(std::max(4.0, std::floor(greatest / kBin_deg) + 1.0));
  std::vector<std::array<std::size_t, 4>> counts(bins, {0, 0, 0, 0});
  std::array<std::size_t, 4> without{0, 0, 0, 0};
  for (const auto& r : rocks) {
    if (r.rejected) continue;
    const auto g = static_cast<std::size_t>(std::find(kGrades.begin(), kGrades.end(), r.grade) - kGrades.begin());
    if (r.alpha_deg) ++counts[std::min(bins - 1, static_cast<std::size_t>(*r.alpha_deg / kBin_deg))][g];
    else ++without[g];
  }
  const auto total = [](const std::array<std::size_t, 4>& c) { return c[0] + c[1] + c[2] + c[3]; };
  std::size_t peak = total(without);
  for (const auto& c : counts) peak = std::max(peak, total(c));
  const std::size_t step = count_step(std::max<std::size_t>(peak, 1));
  const std::size_t top = (peak + step - 1) / step * step;
  open(h, kLeft + kWidth + kRight + 10.0, kTop + kHeight + 46.0, "Histogram of least tipping angles, stacked by grade");
  const auto y_of = [&](double count) {
    return kTop + kHeight * (1.0 - count / static_cast<double>(std::max<std::size_t>(top, 1)));
  };
  for (std::size_t c = 0; c <= top; c += step) {
    const double y = y_of(static_cast<double>(c));
    line(h, kLeft, y, kLeft + kWidth + kRight, y, c == 0 ? "#555555" : "#dddddd", 1.0);
    label(h, kLeft - 6.0, y + 3.5, "end", 10.0, std::to_string(c));
  }
  const auto bar = [&](double x, double width, const std::array<std::size_t, 4>& c, const std::string& what) {
    std::size_t below = 0;
    for (std::size_t g = 0; g < 4; ++g) {
      if (c[g] == 0) continue;
      const double y0 = y_of(static_cast<double>(below)), y1 = y_of(static_cast<double>(below + c[g]));
      below += c[g];
      h.raw("<rect").attr("x", x + 0.8).attr("width", width - 1.6).attr("y", y1).attr("height", y0 - y1);
      h.attr("fill", grade_colour(kGrades[g])).raw("><title>");
      h.text(what + ": " + std::to_string(c[g]) + " " + std::string(grade_label(kGrades[g]))).raw("</title></rect>");
    }
    if (below > 0)
      label(h, x + 0.5 * width, y_of(static_cast<double>(below)) - 3.0, "middle", 10.0, std::to_string(below));
  };
  const double width = kWidth / static_cast<double>(bins);
  for (std::size_t b = 0; b < bins; ++b) {
    const double from = kBin_deg * static_cast<double>(b);
    bar(kLeft + width * static_cast<double>(b), width, counts[b],
        num(from) + " to " + num(from + kBin_deg) + " degrees");
    label(h, kLeft + width * static_cast<double>(b), kTop + kHeight + 14.0, "middle", 10.0, num(from));
  }
  label(h, kLeft + kWidth, kTop + kHeight + 14.0, "middle", 10.0, num(kBin_deg * static_cast<double>(bins)));
  bar(kLeft + kWidth + 24.0, kRight - 34.0, without, "no angle");
  label(h, kLeft + kWidth + 24.0 + 0.5 * (kRight - 34.0), kTop + kHeight + 14.0, "middle", 10.0, "no angle");
  label(h, kLeft + 0.5 * kWidth, kTop + kHeight + 34.0, "middle", 11.0, "least tipping angle \u03b1 [deg]");
  double x = kLeft;
  for (std::size_t g = 0; g < 4; ++g) {
    h.raw("<rect y=\"6\" width=\"10\" height=\"10\"").attr("x", x).attr("fill", grade_colour(kGrades[g])).raw("/>");
    std::size_t all = without[g];
    for (const auto& c : counts) all += c[g];
    label(h, x + 14.0, 15.0, "start", 10.5, std::string(grade_label(kGrades[g])) + " " + std::to_string(all));
    x += 126.0;
  }
  h.raw("</svg>");
  return h;
}

Html reject_chart(const std::vector<SiteRock>& rocks) {
  std::map<std::string, std::size_t> counts;
  for (const auto& r : rocks)
    if (r.rejected)
      for (const auto& reason : r.reasons) ++counts[reason];
  Html h;
  if (counts.empty()) return h;
  std::vector<std::pair<std::string, std::size_t>> order(counts.begin(), counts.end());
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  constexpr double kLeft = 190.0, kWidth = 380.0, kLine = 22.0;
  open(h, kLeft + kWidth + 50.0, 10.0 + kLine * static_cast<double>(order.size()), "Rejected rocks by reason");
  for (std::size_t i = 0; i < order.size(); ++i) {
    const double y = 6.0 + kLine * static_cast<double>(i);
    const double width = kWidth * static_cast<double>(order[i].second) / static_cast<double>(order.front().second);
    std::string words = order[i].first;
    std::replace(words.begin(), words.end(), '_', ' ');
    label(h, kLeft - 8.0, y + 12.5, "end", 11.0, words);
    h.raw("<rect height=\"16\" fill=\"#8a8378\"").attr("x", kLeft).attr("y", y).attr("width", width).raw("><title>");
    h.text(reason_sentence(order[i].first)).raw("</title></rect>");
    label(h, kLeft + width + 6.0, y + 12.5, "start", 11.0, std::to_string(order[i].second));
  }
  h.raw("</svg>");
  return h;
}

Html site_map(const std::vector<SiteRock>& rocks) {
  Html h;
  std::vector<const SiteRock*> placed;
  Vec2 lo = Vec2::Constant(1e300), hi = Vec2::Constant(-1e300);
  for (const auto& r : rocks)
    if (r.place) {
      placed.push_back(&r);
      lo = lo.cwiseMin(*r.place);
      hi = hi.cwiseMax(*r.place);
    }
  if (placed.size() < 2) return h;
  constexpr double kSide = 620.0, kMargin = 34.0;
  const double span = std::max({(hi - lo).maxCoeff(), 1.0});
  const double scale = kSide / span;  // px per m
  const double width = std::max(240.0, (hi - lo).x() * scale) + 2.0 * kMargin;
  const double height = std::max(160.0, (hi - lo).y() * scale) + 2.0 * kMargin;
  const Vec2 middle = 0.5 * (lo + hi);
  const auto pixel = [&](const Vec2& p) {
    return Vec2(0.5 * width + (p.x() - middle.x()) * scale, 0.5 * height - (p.y() - middle.y()) * scale);
  };
  open(h, width, height, "Map of the rocks, north up, coloured by grade; arrows point the way they topple");
  for (const auto* r : placed) {
    const Vec2 p = pixel(*r->place);
    h.raw("<g><title>").text(r->label).raw("</title>");
    if (r->rejected) {
      line(h, p.x() - 3.0, p.y() - 3.0, p.x() + 3.0, p.y() + 3.0, "#999999", 1.2);
      line(h, p.x() - 3.0, p.y() + 3.0, p.x() + 3.0, p.y() - 3.0, "#999999", 1.2);
    } else {
      if (r->toward_deg) {
        const double a = base::deg_to_rad(*r->toward_deg);
        line(h, p.x(), p.y(), p.x() + 15.0 * std::sin(a), p.y() - 15.0 * std::cos(a), "#cc0000", 1.6);
      }
      h.raw("<circle r=\"5\" stroke=\"#1c1c1c\" stroke-width=\"0.8\"").attr("cx", p.x()).attr("cy", p.y());
      h.attr("fill", grade_colour(r->grade)).raw("/>");
    }
    label(h, p.x() + 7.0, p.y() - 5.0, "start", 9.5, r->label);
    h.raw("</g>");
  }
  double bar = nice_ceiling(span / 5.0);
  h.raw("<path fill=\"none\" stroke=\"#111111\" stroke-width=\"1.4\"");
  h.attr("d", "M10 " + num(height - 14.0) + "v4h" + num(bar * scale) + "v-4").raw("/>");
  label(h, 12.0, height - 17.0, "start", 10.0, num(bar) + " m");
  h.raw("<path fill=\"#111111\"").attr("d", "M" + num(width - 18.0) + " 10l5 14l-5 -3l-5 3z").raw("/>");
  label(h, width - 18.0, 36.0, "middle", 10.0, "N");
  h.raw("</svg>");
  return h;
}

std::string site_page(const std::string& title, const std::vector<std::string>& notes,
                      const std::vector<SiteRock>& rocks, bool with_map) {
  const auto rejected =
      static_cast<std::size_t>(std::count_if(rocks.begin(), rocks.end(), [](const auto& r) { return r.rejected; }));
  Html h;
  h.raw(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
      "http-equiv=\"Content-Security-Policy\""
      " content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action "
      "'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>");
  h.text(title).raw(
      "</title>\n<style>body{font:15px/1.45 system-ui,'Noto Sans','DejaVu Sans',sans-serif;margin:0 auto;"
      "max-width:1240px;padding:24px;color:#1c1c1c;background:#fff}h1{font-size:24px;margin:0 0 6px}"
      "h2{font-size:18px;margin:30px 0 8px}p{margin:4px 0}svg{max-width:100%;height:auto;display:block}"
      "svg.map{max-width:800px}.two{display:flex;flex-wrap:wrap;gap:24px}.two>div{flex:1 1 "
      "420px}.quiet{color:#555}</style>\n"
      "</head>\n<body>\n<h1>");
  h.text(title).raw("</h1>\n<p>");
  h.text(std::to_string(rocks.size() - rejected) + " rocks, " + std::to_string(rejected) + " rejected.").raw("</p>\n");
  for (const auto& note : notes) h.raw("<p class=\"quiet\">").text(note).raw("</p>\n");
  h.raw("<div class=\"two\"><div><h2>Tipping angles by grade</h2>").add(grade_histogram(rocks)).raw("</div>");
  if (rejected > 0) h.raw("<div><h2>Rejected, by reason</h2>").add(reject_chart(rocks)).raw("</div>");
  h.raw(
      "</div>\n<h2>Contact sheet</h2>\n<p class=\"quiet\">By grade, then by least tipping angle. Each rock is seen "
      "from "
      "the side, so that it falls to the right; white: centre of mass; black: the contact as seen; red: to the "
      "rocking point. In brackets the 5 % and 95 % quantiles. The size in the picture differs from rock to rock: see "
      "the bar.</p>\n");
  h.add(contact_sheet(rocks));
  if (with_map) {
    const Html map = site_map(rocks);
    if (!map.empty())
      h.raw("\n<h2>Map</h2>\n<p class=\"quiet\">Local frame, north up; crosses were rejected.</p>\n<div class=\"map\">")
          .add(map)
          .raw("</div>");
  }
  h.raw("\n</body>\n</html>\n");
  return std::move(h).str();
}

}  // namespace cairn::report
