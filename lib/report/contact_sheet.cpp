#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/number_text.hpp"
#include "report/base64.hpp"
#include "report/definitions.hpp"
#include "report/site_figures.hpp"

namespace cairn::report {
namespace {

using geometry::Vec2;
using survey::Grade;

constexpr std::size_t kColumns = 8;
constexpr std::size_t kPictureWidth = 132, kPictureHeight = 112, kMargin = 12;
constexpr double kCellWidth = 148.0, kCellHeight = 178.0, kTop = 34.0;

int rank(Grade grade) {
  switch (grade) {
    case Grade::measured: return 0;
    case Grade::bounded: return 1;
    case Grade::screening: return 2;
    case Grade::not_measurable: return 3;
  }
  return 3;
}

std::string num(double v, int decimals) {
  return Html::short_number(v, decimals);
}

// A length that is easy to read, about a third of the picture.
double scale_bar(double span_m) {
  const double power = std::pow(10.0, std::floor(std::log10(span_m / 3.0)));
  for (const double step : {5.0, 2.0, 1.0})
    if (step * power <= span_m / 3.0) return step * power;
  return power;
}

// Rocking points as seen: ends of the contact, each with the line to the centre of mass; the plumb line.
void marks(Html& h, const SiteRock& rock) {
  const RockPicture& p = *rock.picture;
  const auto clamp_to_cell = [](Vec2 q) {
    return Vec2(std::clamp(q.x(), 0.0, double{kPictureWidth}), std::clamp(q.y(), 0.0, double{kPictureHeight}));
  };
  const auto line = [&](const Vec2& from, const Vec2& to, const char* colour, const char* dash) {
    const Vec2 a = clamp_to_cell(from), b = clamp_to_cell(to);
    h.raw("<line").attr("x1", a.x(), 1).attr("y1", a.y(), 1).attr("x2", b.x(), 1).attr("y2", b.y(), 1);
    h.attr("stroke", colour).attr("stroke-dasharray", dash).raw(" stroke-width=\"1.2\"/>");
  };
  if (!rock.centre_of_mass) return;
  const Vec2 com = p.pixel(*rock.centre_of_mass);
  if (rock.alpha_deg && rock.contact.size() >= 2) {
    const auto end = std::max_element(rock.contact.begin(), rock.contact.end(),
                                      [&](const auto& a, const auto& b) { return a.dot(p.right) < b.dot(p.right); });
    const auto start = std::min_element(rock.contact.begin(), rock.contact.end(),
                                        [&](const auto& a, const auto& b) { return a.dot(p.right) < b.dot(p.right); });
    const Vec2 right = p.pixel(*end), left = p.pixel(*start);
    line(left, right, "#111111", "none");
    line(com, {com.x(), right.y()}, "#111111", "2 2");
    line(com, right, "#cc0000", "none");
    for (const Vec2& q : {left, right}) {
      const Vec2 c = clamp_to_cell(q);
      h.raw("<circle").attr("cx", c.x(), 1).attr("cy", c.y(), 1).raw(" r=\"2.2\" fill=\"#111111\"/>");
    }
  }
  const Vec2 c = clamp_to_cell(com);
  h.raw("<circle").attr("cx", c.x(), 1).attr("cy", c.y(), 1);
  h.raw(" r=\"3\" fill=\"#ffffff\" stroke=\"#111111\" stroke-width=\"1.3\"/>");
}

void cell(Html& h, const SiteRock& rock, double x, double y) {
  h.raw("<g").attr("transform", "translate(" + num(x, 1) + " " + num(y, 1) + ")").raw(">");
  std::string title = rock.label + ": " + std::string(grade_label(rock.grade));
  if (rock.alpha_deg) title += ", least tipping angle " + base::to_fixed(*rock.alpha_deg, 1) + " degrees";
  h.raw("<title>").text(title).raw("</title>");
  h.raw("<rect x=\"0.5\" y=\"0.5\"").attr("width", kCellWidth - 8.0).attr("height", kCellHeight - 8.0);
  h.raw(" rx=\"3\" fill=\"#fbfaf8\" stroke=\"#cfcac2\"/>");
  h.raw("<rect x=\"0.5\" y=\"0.5\" width=\"5\"")
      .attr("height", kCellHeight - 8.0)
      .attr("fill", grade_colour(rock.grade));
  h.raw("/>");
  h.raw("<g transform=\"translate(7 22)\">");
  if (rock.picture) {
    const RockPicture& p = *rock.picture;
    h.raw("<image x=\"0\" y=\"0\"").attr("width", std::to_string(p.image.width));
    h.attr("height", std::to_string(p.image.height)).raw(" href=\"data:image/png;base64,");
    h.made(base64(encode_png(p.image))).raw("\"/>");
    marks(h, rock);
    const double bar = scale_bar(static_cast<double>(kPictureWidth) * p.m_per_px);
    h.raw("<path fill=\"none\" stroke=\"#111111\" stroke-width=\"1.4\"");
    h.attr("d", "M2 108v3h" + num(bar / p.m_per_px, 1) + "v-3").raw("/>");
    h.raw("<text x=\"2\" y=\"104\" font-size=\"8.5\" fill=\"#444444\">").text(num(bar, 3) + " m").raw("</text>");
  } else {
    h.raw("<text x=\"62\" y=\"60\" font-size=\"10\" text-anchor=\"middle\" fill=\"#777777\">no picture</text>");
  }
  h.raw("</g>");
  if (!rock.href.empty()) h.raw("<a").attr("href", rock.href).raw(">");
  h.raw("<text x=\"11\" y=\"16\" font-size=\"12\" font-weight=\"600\" fill=\"#1c1c1c\">")
      .text(rock.label)
      .raw("</text>");
  if (!rock.href.empty()) h.raw("</a>");
  if (rock.review == "accept" || !rock.judgement.empty()) {
    const std::string word = rock.judgement.empty() ? "accepted" : rock.judgement;
    std::string shown = word;
    std::replace(shown.begin(), shown.end(), '_', ' ');
    h.raw("<text text-anchor=\"end\" y=\"16\" font-size=\"9\" fill=\"#7a3b00\"").attr("x", kCellWidth - 14.0);
    h.raw(">").text(shown).raw("</text>");
  }
  std::string first = "no angle may be given";
  if (rock.alpha_deg) {
    first = "\u03b1 " + base::to_fixed(*rock.alpha_deg, 1) + "\u00b0";
    if (rock.alpha_90_deg)
      first += " (" + base::to_fixed(rock.alpha_90_deg->first, 0) + "\u2013" +
               base::to_fixed(rock.alpha_90_deg->second, 0) + ")";
    if (rock.toward_deg) first += " \u2192 " + base::to_fixed(*rock.toward_deg, 0) + "\u00b0";
  }
  h.raw("<text x=\"11\" y=\"148\" font-size=\"10.5\" fill=\"#1c1c1c\">").text(first).raw("</text>");
  h.raw("<text x=\"11\" y=\"162\" font-size=\"9.5\" fill=\"#555555\">").text(grade_label(rock.grade));
  if (rock.height_m > 0.0) h.text(", H " + base::to_fixed(rock.height_m, 2) + " m");
  h.raw("</text></g>");
}

}  // namespace

std::string_view grade_colour(Grade grade) {
  switch (grade) {
    case Grade::measured: return "#009e73";
    case Grade::bounded: return "#0072b2";
    case Grade::screening: return "#e69f00";
    case Grade::not_measurable: return "#999999";
  }
  return "#999999";
}

RockPicture sheet_picture(const geometry::TriangleMesh& mesh, const std::vector<std::uint8_t>& facet_seen,
                          std::optional<double> toward_deg) {
  return draw_rock(mesh, facet_seen, toward_deg.value_or(90.0), kPictureWidth, kPictureHeight, kMargin);
}

std::vector<std::size_t> sheet_order(const std::vector<SiteRock>& rocks) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < rocks.size(); ++i)
    if (!rocks[i].rejected) order.push_back(i);
  const auto key = [&](std::size_t i) {
    return std::pair(rank(rocks[i].grade), rocks[i].alpha_deg.value_or(std::numeric_limits<double>::infinity()));
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  return order;
}

Html contact_sheet(const std::vector<SiteRock>& rocks) {
  const auto order = sheet_order(rocks);
  Html h;
  if (order.empty()) return h;
  const std::size_t columns = std::min(kColumns, order.size());
  const std::size_t lines = (order.size() + columns - 1) / columns;
  // Room for the legend.
  const double width = std::max(kCellWidth * static_cast<double>(columns) + 2.0, 720.0);
  const double height = kTop + kCellHeight * static_cast<double>(lines) + 2.0;
  h.raw("<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"contact-sheet\" role=\"img\"")
      .attr("viewBox", "0 0 " + num(width, 1) + " " + num(height, 1));
  h.attr("aria-label", "Contact sheet of " + std::to_string(order.size()) + " rocks, by grade and least tipping angle");
  h.raw(" font-family=\"system-ui, 'Noto Sans', 'DejaVu Sans', sans-serif\">");
  h.raw("<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>");
  double x = 2.0;
  for (const auto grade : {Grade::measured, Grade::bounded, Grade::screening, Grade::not_measurable}) {
    const auto count =
        std::count_if(order.begin(), order.end(), [&](std::size_t i) { return rocks[i].grade == grade; });
    h.raw("<rect y=\"8\" width=\"11\" height=\"11\"").attr("x", x).attr("fill", grade_colour(grade)).raw("/>");
    h.raw("<text y=\"17.5\" font-size=\"11\" fill=\"#1c1c1c\"").attr("x", x + 16.0).raw(">");
    h.text(std::string(grade_label(grade)) + " " + std::to_string(count)).raw("</text>");
    x += 140.0;
  }
  const bool closed = std::any_of(rocks.begin(), rocks.end(), [](const SiteRock& r) {
    return r.picture && std::any_of(r.picture->image.pixels.begin(), r.picture->image.pixels.end(),
                                    [](std::uint8_t pixel) { return pixel > kSeenColours; });
  });
  if (closed) {
    h.raw("<rect y=\"8\" width=\"11\" height=\"11\" fill=\"#d6966e\"").attr("x", x).raw("/>");
    h.raw("<text y=\"17.5\" font-size=\"11\" fill=\"#1c1c1c\"").attr("x", x + 16.0).raw(">closed, not seen</text>");
  }
  for (std::size_t n = 0; n < order.size(); ++n)
    cell(h, rocks[order[n]], 2.0 + kCellWidth * static_cast<double>(n % columns),
         kTop + kCellHeight * static_cast<double>(n / columns));
  h.raw("</svg>");
  return h;
}

}  // namespace cairn::report
