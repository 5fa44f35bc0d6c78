// Coverage, obstacles and route, provenance, and how to read the page.
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
constexpr std::size_t kRejectRows = 200;

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
      h.raw("<div class=\"gate-row\"><span>").text(words_of(g.name)).raw("</span><span class=\"quiet\">").text(g.rule);
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
  h.raw(
      "</div><p class=\"quiet\">Share of the surface's area in each bin. Bars beyond a gate are hatched in another "
      "tone.</p>");
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

Html provenance_section(const PageContext& page) {
  const ReportData& d = page.data;
  const Provenance& p = d.provenance;
  const survey::Origin& o = d.manifest.origin;
  Html h;
  h.raw("<section id=\"provenance\"><h2>Provenance</h2><dl class=\"facts wide\">");
  const auto fact = [&h](std::string_view name, std::string_view value) {
    h.raw("<div><dt>").text(name).raw("</dt><dd>").text(value).raw("</dd></div>");
  };
  fact("Program", "cairn " + p.version);
  if (!p.recipe.empty()) fact("Recipe", p.recipe);
  fact("Seed", std::to_string(p.seed));
  fact("Origin of the local frame",
       latitude_text(o.position.latitude_deg) + ", " + longitude_text(o.position.longitude_deg) + ", height " +
           fixed(o.position.height_m, 2) + "\u202fm " + words_of(survey::name_of(o.height_type)) +
           (o.geoid.empty() ? "" : " (" + o.geoid + ")"));
  fact("Axes", "x east, y north, z up; metres; tangent plane at the origin, WGS 84");
  fact("Rasters",
       "transverse Mercator centred on the origin, equal to the local frame to a millimetre over a kilometre");
  for (const std::string& operation : p.crs_operations) fact("Coordinate operation", operation);
  h.raw("</dl>");
  if (!d.manifest.sources.empty()) {
    h.raw(
        "<h3>Sources</h3><div class=\"table-frame\"><table "
        "class=\"plain\"><thead><tr><th>kind</th><th>path</th><th>convention</th><th>confidence</th><th>CRS</"
        "th><th>heights</th></tr></thead><tbody>");
    for (const survey::Source& s : d.manifest.sources)
      h.raw("<tr><th scope=\"row\">")
          .text(s.kind)
          .raw("</th><td class=\"path\">")
          .text(s.path)
          .raw("</td><td>")
          .text(s.convention)
          .raw("</td><td>")
          .text(survey::name_of(s.confidence))
          .raw("</td><td class=\"path\">")
          .text(s.crs)
          .raw("</td><td>")
          .text(words_of(survey::name_of(s.height_type)))
          .raw("</td></tr>");
    h.raw("</tbody></table></div>");
  }
  if (!d.manifest.notes.empty() || !p.warnings.empty()) {
    h.raw("<h3>Notes and warnings</h3><ul class=\"warnings\">");
    for (const std::string& w : p.warnings) h.raw("<li class=\"warning\">").text(w).raw("</li>");
    for (const std::string& n : d.manifest.notes) h.raw("<li>").text(n).raw("</li>");
    h.raw("</ul>");
  }
  if (!d.rejects.empty()) {
    std::map<std::pair<std::string, std::string>, std::size_t> counts;
    for (const StageReject& r : d.rejects) ++counts[{r.stage, r.reject.reason}];
    h.raw(
        "<h3>Rejected records</h3><div class=\"table-frame\"><table "
        "class=\"plain\"><thead><tr><th>stage</th><th>reason</th><th>meaning</th><th "
        "class=\"n\">records</th></tr></thead><tbody>");
    for (const auto& [key, n] : counts)
      h.raw("<tr><th scope=\"row\">")
          .text(key.first)
          .raw("</th><td><code>")
          .text(key.second)
          .raw("</code></td><td>")
          .text(reason_sentence(key.second))
          .raw("</td><td class=\"n\">")
          .text(grouped(n))
          .raw("</td></tr>");
    h.raw("</tbody></table></div><details><summary>")
        .text("Every rejected record (" + grouped(d.rejects.size()) + ")")
        .raw("</summary><ul class=\"records\">");
    for (std::size_t i = 0; i < std::min(d.rejects.size(), kRejectRows); ++i)
      h.raw("<li><b>")
          .text(d.rejects[i].reject.record)
          .raw("</b> <code>")
          .text(d.rejects[i].reject.reason)
          .raw("</code> ")
          .text(d.rejects[i].reject.message)
          .raw("</li>");
    if (d.rejects.size() > kRejectRows)
      h.raw("<li>").text(grouped(d.rejects.size() - kRejectRows) + " more in run.json").raw("</li>");
    h.raw("</ul></details>");
  }
  if (!p.inputs.empty()) {
    h.raw("<details><summary>")
        .text("Input files and their SHA-256 (" + grouped(p.inputs.size()) + ")")
        .raw("</summary><div class=\"table-frame\"><table class=\"plain hashes\"><tbody>");
    for (const InputFile& f : p.inputs)
      h.raw("<tr><td class=\"path\">").text(f.path).raw("</td><td><code>").text(f.sha256).raw("</code></td></tr>");
    h.raw("</tbody></table></div></details>");
  }
  if (!p.options.is_null())
    h.raw("<details><summary>Options</summary><pre>").text(p.options.dump(2)).raw("</pre></details>");
  h.raw("</section>");
  return h;
}

Html reading_section() {
  Html h;
  h.raw(
      "<section id=\"reading\"><h2>How to read this report</h2><div class=\"reading\"><div><h3>Grades</h3><dl "
      "class=\"grades\">");
  for (const survey::Grade g :
       {survey::Grade::measured, survey::Grade::bounded, survey::Grade::screening, survey::Grade::not_measurable})
    h.raw("<div><dt>").add(grade_badge(g)).raw("</dt><dd>").text(grade_meaning(g)).raw("</dd></div>");
  h.raw(
      "</dl><h3>Words</h3><p>A located or cut rock is a <i>candidate</i>. Whether it is <i>precarious</i> is a "
      "judgement made in review, "
      "not in this report. Coverage is <i>predicted visibility</i>. Positions are relative to the survey's local "
      "frame; the absolute position is as good as "
      "the GNSS of the photographs.</p><h3>States of a located object</h3><dl class=\"codes\">");
  for (const auto s : {survey::TargetState::generated, survey::TargetState::converging, survey::TargetState::converged,
                       survey::TargetState::mapped, survey::TargetState::deregistered})
    h.raw("<div><dt><code>").text(survey::name_of(s)).raw("</code></dt><dd>").text(state_meaning(s)).raw("</dd></div>");
  h.raw("</dl></div><div><h3>Quantities</h3><dl class=\"terms\">");
  for (const Term& t : terms()) {
    h.raw("<div><dt><b>").symbol(t.symbol).raw("</b> ").text(t.name);
    if (!t.unit.empty()) h.raw(" <span class=\"quiet\">[").text(t.unit).raw("]</span>");
    h.raw("</dt><dd>").text(t.definition).raw("</dd></div>");
  }
  h.raw("</dl></div></div></section>");
  return h;
}

}  // namespace cairn::report
