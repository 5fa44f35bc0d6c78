// Title, key figures, and what the survey shows in a few sentences.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "base/time.hpp"
#include "report/definitions.hpp"
#include "report/sections.hpp"

namespace cairn::report {
namespace {

using survey::Grade;
constexpr std::array kGrades{Grade::measured, Grade::bounded, Grade::screening, Grade::not_measurable};

struct Counts {
  std::map<Grade, std::size_t> grades;
  std::size_t cut = 0, rejected = 0, located = 0, given_up = 0;
};

Counts count(const PageContext& page) {
  Counts n;
  for (const RockView& r : page.data.rocks) {
    if (r.rock.rejected) {
      ++n.rejected;
    } else {
      ++n.cut;
      ++n.grades[r.rock.tipping.grade];
    }
  }
  for (const TargetView& t : page.data.targets)
    ++(t.target.state == survey::TargetState::deregistered ? n.given_up : n.located);
  return n;
}

std::string date_text(const PageContext& page) {
  std::int64_t first = 0, last = 0;
  for (const FrameView& f : page.data.frames) {
    if (f.frame.time_ns == 0) continue;
    first = first == 0 ? f.frame.time_ns : std::min(first, f.frame.time_ns);
    last = std::max(last, f.frame.time_ns);
  }
  if (first == 0 || page.data.manifest.time_base == base::TimeBase::boot) return "";
  const std::string from = base::iso8601(first), to = base::iso8601(last);
  const auto day = [](const std::string& iso) {
    static constexpr std::array<std::string_view, 12> kMonths{"January",   "February", "March",    "April",
                                                              "May",       "June",     "July",     "August",
                                                              "September", "October",  "November", "December"};
    const auto month = static_cast<std::size_t>(base::parse_integer(iso.substr(5, 2)).value_or(1) - 1);
    return std::to_string(base::parse_integer(iso.substr(8, 2)).value_or(1)) + " " +
           std::string(kMonths[std::min<std::size_t>(month, 11)]) + " " + iso.substr(0, 4);
  };
  const auto clock = [](const std::string& iso) { return iso.substr(11, 5); };
  std::string text = day(from) + ", " + clock(from);
  if (from.substr(0, 10) != to.substr(0, 10)) text += " to " + day(to) + ", " + clock(to);
  else if (clock(from) != clock(to)) text += "–" + clock(to);
  switch (page.data.manifest.time_base) {
    case base::TimeBase::utc: return text + " UTC";
    case base::TimeBase::gps: return text + " GPS time";
    default: return text + " (camera clock)";
  }
}

void figure(Html& h, const std::string& value, std::string_view unit, std::string_view label,
            const std::string& detail) {
  h.raw("<div class=\"figure\"><dt>").text(label).raw("</dt><dd><span class=\"value\">").text(value);
  if (!unit.empty()) h.raw("<span class=\"unit\">").text(unit).raw("</span>");
  h.raw("</span><span class=\"detail\">").text(detail).raw("</span></dd></div>");
}

std::string class_counts(const PageContext& page) {
  std::map<std::string, std::size_t> n;
  for (const TargetView& t : page.data.targets)
    if (t.target.state != survey::TargetState::deregistered) ++n[t.target.object_class];
  std::vector<std::pair<std::size_t, std::string>> order;
  for (const auto& [name, c] : n) order.emplace_back(c, name);
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (const auto& [c, name] : order) text += (text.empty() ? "" : ", ") + words_of(name) + "\u00a0" + grouped(c);
  return text;
}

void grade_bar(Html& h, const Counts& n) {
  h.raw("<div class=\"figure wide\"><dt>Grades of the rocks</dt><dd><span class=\"gradebar\" aria-hidden=\"true\">");
  for (const Grade g : kGrades) {
    const auto it = n.grades.find(g);
    if (it == n.grades.end()) continue;
    h.raw("<i")
        .attr("class", "grade-" + std::string(survey::name_of(g)))
        .attr("style", "flex-grow:" + std::to_string(it->second))
        .raw("></i>");
  }
  h.raw("</span><span class=\"gradekey\">");
  for (const Grade g : kGrades) {
    const auto it = n.grades.find(g);
    h.raw("<span").attr("title", grade_meaning(g)).raw("><b>").text(grouped(it == n.grades.end() ? 0 : it->second));
    h.raw("</b> ").text(grade_label(g)).raw("</span>");
  }
  h.raw("</span></dd></div>");
}

// The reason code most often given by the rocks of a grade, of those that can decide it.
std::string common_reason(const PageContext& page, Grade grade) {
  std::map<std::string, std::size_t> n;
  for (const RockView& r : page.data.rocks)
    if (!r.rock.rejected && r.rock.tipping.grade == grade)
      for (const std::string& code : r.rock.tipping.reasons)
        if (grade == Grade::screening || !(code == "contact_assumed" || code.starts_with("partly_"))) ++n[code];
  const auto most =
      std::max_element(n.begin(), n.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == n.end() ? "" : most->first;
}

double median(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

Html header_section(const PageContext& page) {
  const survey::Manifest& m = page.data.manifest;
  const geometry::Geodetic& origin = m.origin.position;
  const Counts n = count(page);
  Html h;
  h.raw("<header class=\"masthead\"><p class=\"kicker\">Survey report</p><h1>")
      .text(page.title)
      .raw("</h1><p class=\"place\">");
  const std::string date = date_text(page);
  if (!date.empty()) h.raw("<span>").text(date).raw("</span>");
  const auto short_degrees = [](const std::string& text) {
    const std::size_t point = text.find('.'), sign = text.find("°");
    return point == std::string::npos || sign == std::string::npos ? text
                                                                   : text.substr(0, point + 5) + text.substr(sign);
  };
  h.raw("<span>")
      .text(short_degrees(latitude_text(origin.latitude_deg)) + ", " +
            short_degrees(longitude_text(origin.longitude_deg)))
      .raw("</span>");
  h.raw("<span>")
      .text("heights: " + words_of(survey::name_of(m.origin.height_type)) +
            (m.origin.geoid.empty() ? "" : " (" + m.origin.geoid + ")"))
      .raw("</span></p><dl class=\"figures\">");
  if (!page.data.frames.empty())
    figure(h, grouped(page.data.frames.size()), "", "Photographs",
           page.data.detections > 0 ? plural(page.data.detections, "detected box", "detected boxes") : "");
  if (!page.data.targets.empty()) figure(h, grouped(n.located), "", "Objects located", class_counts(page));
  if (!page.data.rocks.empty()) {
    figure(h, grouped(n.cut), "", "Rocks cut",
           n.rejected == 0 ? "none rejected" : grouped(n.rejected) + " rejected, each with its reason");
    if (n.cut > 0) grade_bar(h, n);
  }
  if (page.data.coverage) {
    const CoverageView& c = *page.data.coverage;
    std::string detail = "of " + grouped(static_cast<std::size_t>(std::lround(c.area_m2))) + "\u202fm² pass every gate";
    if (c.interval_95)
      detail += "; 95\u202f%: " + fixed(100 * (*c.interval_95)[0], 1) + "–" + fixed(100 * (*c.interval_95)[1], 1);
    figure(h, fixed(100.0 * c.complete_fraction, 1), "%", "Predicted coverage", detail);
  }
  if (!page.data.obstacles.empty()) {
    const auto ignored = static_cast<std::size_t>(
        std::count_if(page.data.obstacles.begin(), page.data.obstacles.end(),
                      [](const survey::Obstacle& o) { return o.kind == survey::ObstacleKind::ignored; }));
    figure(h, grouped(page.data.obstacles.size() - ignored), "", "Obstacles",
           ignored == 0 ? "" : grouped(ignored) + " more seen and ignored");
  }
  if (page.data.route)
    figure(h, fixed(page.data.route->length_m, 1), "m", "Route",
           page.data.route->min_clearance_m
               ? "clearance at least " + fixed(*page.data.route->min_clearance_m, 2) + "\u202fm"
               : page.data.route->planner);
  h.raw("</dl></header>");
  return h;
}

Html summary_section(const PageContext& page) {
  const Counts n = count(page);
  std::vector<std::string> lines;
  if (n.located > 0) {
    std::vector<double> sigmas;
    for (const TargetView& t : page.data.targets)
      if (t.target.state != survey::TargetState::deregistered) sigmas.push_back(horizontal_sigma(t.target.covariance));
    lines.push_back(
        plural(n.located, "object was", "objects were") + " located in 3-D" +
        (page.data.detections > 0 ? " from " + plural(page.data.detections, "box", "boxes") + " in " +
                                        plural(page.data.frames.size(), "photograph", "photographs")
                                  : "") +
        "; median horizontal uncertainty " + fixed(median(sigmas), 3) +
        "\u202fm (one sigma, relative to the survey's own frame)." +
        (n.given_up > 0 ? " " + plural(n.given_up, "candidate was", "candidates were") + " given up." : ""));
  }
  if (n.cut > 0) {
    const auto of = [&](Grade g) { return n.grades.contains(g) ? n.grades.at(g) : std::size_t{0}; };
    if (of(Grade::measured) == 0)
      lines.push_back(
          "No rock could be graded measured. Every tipping figure below is a limit or a screening value, and " +
          std::to_string(of(Grade::not_measurable)) + " of " + std::to_string(n.cut) + " rocks have none at all.");
    for (const Grade g : {Grade::screening, Grade::not_measurable}) {
      const std::string reason = common_reason(page, g);
      if (of(g) > 0 && !reason.empty())
        lines.push_back("Most common reason for " + std::string(grade_label(g)) + ": " + reason_sentence(reason));
    }
    const RockView* least = nullptr;
    for (const RockView& r : page.data.rocks)
      if (!r.rock.rejected && r.rock.tipping.grade != Grade::not_measurable && r.rock.tipping.critical &&
          (least == nullptr || r.rock.tipping.critical->alpha_rad < least->rock.tipping.critical->alpha_rad))
        least = &r;
    if (least != nullptr)
      lines.push_back(
          "Least tipping angle with a grade: " + fixed(base::rad_to_deg(least->rock.tipping.critical->alpha_rad), 1) +
          "° (" + words_of(least->rock.object_class) + " " + std::to_string(least->rock.target.value) + ", " +
          std::string(grade_label(least->rock.tipping.grade)) + ").");
  }
  if (page.data.coverage && !page.data.coverage->gaps.empty()) {
    double area = 0.0;
    for (const GapView& g : page.data.coverage->gaps) area += g.area_m2;
    lines.push_back(plural(page.data.coverage->gaps.size(), "gap", "gaps") + " in the coverage, " + fixed(area, 1) +
                    "\u202fm² together; they are listed with reason and place.");
  }
  if (!page.data.provenance.warnings.empty())
    lines.push_back(plural(page.data.provenance.warnings.size(), "warning", "warnings") +
                    " raised while processing: see Provenance.");
  Html h;
  if (lines.empty()) return h;
  h.raw("<section class=\"summary\" id=\"summary\"><h2>What this survey shows</h2><ul>");
  for (const std::string& line : lines) h.raw("<li>").text(line).raw("</li>");
  h.raw("</ul></section>");
  return h;
}

}  // namespace cairn::report
