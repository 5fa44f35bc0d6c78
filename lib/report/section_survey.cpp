// Coverage, obstacles and route.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "report/charts.hpp"
#include "report/definitions.hpp"
#include "report/sections.hpp"

namespace cairn::report {
namespace {

constexpr std::size_t kGapRows = 60;

std::string joined(const std::vector<std::string>& parts, std::string_view separator) {
  std::string text;
  for (const std::string& p : parts) {
    if (!text.empty()) text += separator;
    text += p;
  }
  return text;
}

void gap_table(Html& h, const CoverageView& c) {
  if (c.gaps.empty()) return;
  std::vector<const GapView*> gaps;
  for (const GapView& g : c.gaps) gaps.push_back(&g);
  std::stable_sort(gaps.begin(), gaps.end(),
                   [](const GapView* a, const GapView* b) { return a->area_m2 > b->area_m2; });
  h.raw(
      "<h3>Gaps</h3><p>Connected parts of the surface that fail at least one gate, largest first.</p>"
      "<div class=\"table-frame\"><table class=\"plain\"><thead><tr><th>gap</th><th "
      "class=\"n\">area<small>m²</small></th>"
      "<th class=\"n\">east<small>m</small></th><th class=\"n\">north<small>m</small></th><th>why</th><th>nearest "
      "photographs</th>"
      "</tr></thead><tbody>");
  for (std::size_t i = 0; i < std::min(gaps.size(), kGapRows); ++i) {
    const GapView& g = *gaps[i];
    h.raw("<tr").attr("data-gap", std::to_string(g.id)).attr("data-e", g.centroid.x()).attr("data-n", g.centroid.y());
    h.raw("><th scope=\"row\">").text(std::to_string(g.id)).raw("</th><td class=\"n\">").text(fixed(g.area_m2, 1));
    h.raw("</td><td class=\"n\">")
        .text(fixed(g.centroid.x(), 1))
        .raw("</td><td class=\"n\">")
        .text(fixed(g.centroid.y(), 1))
        .raw("</td><td>");
    for (const std::string& code : g.reasons)
      h.raw("<span class=\"code\"")
          .attr("title", coverage_sentence(code))
          .raw(">")
          .text(words_of(code))
          .raw("</span> ");
    if (!g.suggestion.empty()) h.raw("<small>").text(g.suggestion).raw("</small>");
    h.raw("</td><td class=\"quiet\">").text(joined(g.nearest_frames, ", ")).raw("</td></tr>");
  }
  h.raw("</tbody></table></div>");
  if (gaps.size() > kGapRows)
    h.raw("<p class=\"quiet\">")
        .text(grouped(gaps.size() - kGapRows) + " smaller gaps are in the layer of gaps.")
        .raw("</p>");
  std::map<std::string, std::pair<std::size_t, double>> by_reason;
  for (const GapView& g : c.gaps)
    for (const std::string& code : g.reasons) {
      ++by_reason[code].first;
      by_reason[code].second += g.area_m2;
    }
  h.raw("<dl class=\"codes\">");
  for (const auto& [code, n] : by_reason)
    h.raw("<div><dt><code>")
        .text(code)
        .raw("</code></dt><dd>")
        .text(coverage_sentence(code))
        .raw(" <span class=\"quiet\">")
        .text(plural(n.first, "gap", "gaps") + ", " + fixed(n.second, 1) + "\u202fm²")
        .raw("</span></dd></div>");
  h.raw("</dl>");
}

}  // namespace

Html coverage_section(const PageContext& page) {
  Html h;
  if (!page.data.coverage) return h;
  const CoverageView& c = *page.data.coverage;
  h.raw("<section id=\"coverage\"><h2>Coverage</h2><p class=\"lead\">");
  h.text("Predicted visibility of " + grouped(c.facets) + " facets (" +
         grouped(static_cast<std::size_t>(std::lround(c.area_m2))) +
         "\u202fm²), found by casting rays from every photograph to every facet. " +
         fixed(100.0 * c.complete_fraction, 1) + "\u202f% of the area passes every gate");
  if (c.interval_95)
    h.text(" (95\u202f% interval " + fixed(100 * (*c.interval_95)[0], 1) + " to " +
           fixed(100 * (*c.interval_95)[1], 1) + "\u202f%, block bootstrap)");
  h.text(".").raw("</p>");
  if (c.validation) h.raw("<p>").text(*c.validation).raw("</p>");
  if (!c.gates.empty()) {
    h.raw("<h3>Gates, each on its own</h3><div class=\"gates\">");
    for (const Gate& g : c.gates) {
      const std::string percent = fixed(100.0 * g.pass_fraction, 1);
      h.raw("<div class=\"gate-row\"><span>")
          .text(g.name == "gsd" ? "GSD" : words_of(g.name))
          .raw("</span><span class=\"quiet\">")
          .text(g.rule);
      h.raw("</span><i><b")
          .attr("style", "width:" + Html::short_number(100.0 * std::clamp(g.pass_fraction, 0.0, 1.0), 2) + "%")
          .raw("></b></i><span class=\"n\">");
      h.text(percent + "\u202f% pass").raw("</span></div>");
    }
    h.raw("</div>");
  }
  double total = 0.0;
  for (const VerdictArea& v : c.verdicts) total += v.area_m2;
  if (total > 0.0) {
    h.raw("<h3>What becomes of the surface</h3><div class=\"gates\">");
    for (const VerdictArea& v : c.verdicts) {
      if (!(v.area_m2 > 0.0)) continue;
      const std::string width = Html::short_number(100.0 * v.area_m2 / total, 2);
      h.raw("<div class=\"gate-row\"><span>").text(words_of(v.verdict)).raw("</span><span class=\"quiet\">");
      h.text(fixed(v.area_m2, 0) + "\u202fm²").raw("</span><i");
      if (v.verdict != "passed") h.raw(" class=\"failing\"");
      h.attr("title", coverage_sentence(v.verdict))
          .raw("><b")
          .attr("style", "width:" + width + "%")
          .raw("></b></i><span class=\"n\">");
      h.text(fixed(100.0 * v.area_m2 / total, 1) + "\u202f%").raw("</span></div>");
    }
    h.raw("</div><dl class=\"codes\">");
    for (const VerdictArea& v : c.verdicts)
      if (v.area_m2 > 0.0 && v.verdict != "passed")
        h.raw("<div><dt><code>")
            .text(v.verdict)
            .raw("</code></dt><dd>")
            .text(coverage_sentence(v.verdict))
            .raw("</dd></div>");
    h.raw("</dl>");
  }
  h.raw("<h3>Distribution</h3><div class=\"charts\">");
  for (const Histogram& histogram : c.histograms)
    if (histogram.areas_m2.size() + 1 == histogram.edges.size() && histogram.edges.size() > 1 &&
        histogram.edges.front() < histogram.edges.back())
      h.raw("<figure>").add(histogram_chart(histogram)).raw("</figure>");
  h.raw("</div><p class=\"quiet\">Share of the surface's area in each bin. Sand-coloured bars fail the gate.</p>");
  gap_table(h, c);
  h.raw("</section>");
  return h;
}

Html ground_section(const PageContext& page) {
  const ReportData& d = page.data;
  Html h;
  if (d.obstacles.empty() && !d.route) return h;
  h.raw("<section id=\"ground\"><h2>Obstacles and route</h2>");
  if (d.route) {
    h.raw("<p class=\"lead\">")
        .text("Route of " + fixed(d.route->length_m, 1) + "\u202fm from " +
              fixed(d.route->path.empty() ? 0.0 : d.route->path.front().x(), 1) + ", " +
              fixed(d.route->path.empty() ? 0.0 : d.route->path.front().y(), 1) + " to " +
              fixed(d.route->path.empty() ? 0.0 : d.route->path.back().x(), 1) + ", " +
              fixed(d.route->path.empty() ? 0.0 : d.route->path.back().y(), 1) + "\u202fm (east, north)");
    if (!d.route->planner.empty()) h.text(", " + d.route->planner);
    if (d.route->cost) h.text("; cost " + fixed(*d.route->cost, 1));
    if (d.route->min_clearance_m) h.text("; least clearance " + fixed(*d.route->min_clearance_m, 2) + "\u202fm");
    h.text(". Advisory: a vehicle must still sense what is in front of it.").raw("</p>");
  }
  if (!d.obstacles.empty()) {
    h.raw(
        "<p>What blocks a ground vehicle, what it may pass under (trees are seen and ignored), and other vehicles.</p>"
        "<div class=\"table-frame short\"><table class=\"plain\"><thead><tr><th "
        "class=\"n\">object</th><th>class</th><th>kind</th>"
        "<th class=\"n\">width<small>m</small></th><th class=\"n\">height<small>m</small></th><th "
        "class=\"n\">east<small>m</small></th>"
        "<th class=\"n\">north<small>m</small></th><th class=\"n\">σ horiz.<small>m</small></th><th "
        "class=\"n\">observations</th></tr></thead><tbody>");
    for (const survey::Obstacle& o : d.obstacles) {
      geometry::Mat3 covariance = geometry::Mat3::Zero();
      covariance.topLeftCorner<2, 2>() = o.covariance;
      h.raw("<tr")
          .attr("data-id", std::to_string(o.target.value))
          .raw("><th scope=\"row\" class=\"n\">")
          .text(std::to_string(o.target.value));
      h.raw("</th><td>")
          .add(class_symbol(page, o.object_class))
          .text(words_of(o.object_class))
          .raw("</td><td>")
          .text(survey::name_of(o.kind));
      for (const auto& [value, decimals] : {std::pair{o.width_m, 2},
                                            {o.height_m, 2},
                                            {o.position.x(), 2},
                                            {o.position.y(), 2},
                                            {horizontal_sigma(covariance), 3}})
        h.raw("</td><td class=\"n\">").text(fixed(value, decimals));
      h.raw("</td><td class=\"n\">").text(grouped(o.observations)).raw("</td></tr>");
    }
    h.raw("</tbody></table></div>");
  }
  h.raw("</section>");
  return h;
}

}  // namespace cairn::report
