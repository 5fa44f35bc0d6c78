#include "report/coverage_page.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/number_text.hpp"
#include "report/base64.hpp"
#include "report/charts.hpp"
#include "report/html_text.hpp"
#include "report/palette.hpp"
#include "report/raster_image.hpp"
#include "report/sections.hpp"

namespace cairn::report {
namespace {

constexpr std::size_t kGapRows = 40;
constexpr std::size_t kMapPixels = 900;  // longer side of a picture

std::string percent(double share, int decimals = 1) {
  return fixed(100.0 * share, decimals) + "\u202f%";
}
std::string or_dash(const std::optional<double>& value, int decimals) {
  return value && std::isfinite(*value) ? fixed(*value, decimals) : "–";
}

void map_figure(Html& h, const CoverageMap& map) {
  h.raw("<figure class=\"map\"><figcaption><b>").text(map.title).raw("</b> ").text(map.note).raw("</figcaption>");
  const double scale = 1.0 / static_cast<double>(std::max<std::size_t>(map.image.width, map.image.height));
  h.raw("<img alt=\"\"").attr("title", map.title).raw(" src=\"data:image/png;base64,");
  h.made(base64(encode_png(map.image))).raw("\"");
  h.attr("style", "width:" + Html::short_number(100.0 * scale * static_cast<double>(map.image.width), 1) + "%");
  h.raw("><p class=\"quiet\">");
  h.text(fixed(map.geometry.east() - map.geometry.west, 0) + " by " +
         fixed(map.geometry.north - map.geometry.south(), 0) + "\u202fm, north up");
  h.raw("</p><ul class=\"keys\">");
  for (const CoverageMap::Key& key : map.keys)
    h.raw("<li><i").attr("style", "background:" + css_colour(key.colour)).raw("></i>").text(key.label).raw("</li>");
  h.raw("</ul></figure>");
}

// Inner ring: wall; outer ring: basal band. One sector a step of azimuth, north up.
void rose(Html& h, const CoverageTargetRow& t) {
  constexpr double kSize = 120.0, kMiddle = 0.5 * kSize;
  h.raw("<svg class=\"rose\" viewBox=\"0 0 120 120\" role=\"img\" aria-label=\"Wall and basal band by azimuth\">");
  const auto ring = [&](const std::vector<double>& shares, double from, double to) {
    const auto n = static_cast<double>(shares.size());
    for (std::size_t s = 0; s < shares.size(); ++s) {
      const double a = 2.0 * std::numbers::pi * static_cast<double>(s) / n;
      const double b = 2.0 * std::numbers::pi * static_cast<double>(s + 1) / n;
      const auto at = [&](double radius, double azimuth) {
        return Html::short_number(kMiddle + radius * std::sin(azimuth), 2) + " " +
               Html::short_number(kMiddle - radius * std::cos(azimuth), 2);
      };
      const std::string path = "M" + at(from, a) + "L" + at(to, a) + "L" + at(to, b) + "L" + at(from, b) + "Z";
      const std::string fill = std::isfinite(shares[s]) ? css_colour(cividis(shares[s])) : "#d8d8d8";
      h.raw("<path").attr("d", path).attr("fill", fill).raw("/>");
    }
  };
  ring(t.wall_by_azimuth, 16.0, 38.0);
  ring(t.basal_by_azimuth, 42.0, 54.0);
  h.raw("<path d=\"M60 1L57 6L63 6Z\" fill=\"#1c1c1c\"/></svg>");
}

void target_table(Html& h, const CoveragePage& page) {
  if (page.targets.empty()) return;
  const auto passed = std::count_if(page.targets.begin(), page.targets.end(), [](const auto& t) { return t.passed; });
  h.raw("<h2>Targets</h2><p>");
  h.text(
      std::to_string(passed) + " of " + std::to_string(page.targets.size()) +
      " targets pass. Walls and tops are those of the bounding cylinder. Rings: inner, the wall's share that passes by "
      "azimuth; outer, the basal band seen. Yellow passes, dark blue fails, grey is buried or not there.");
  h.raw(
      "</p><table><thead><tr><th>target</th><th>verdict</th><th>height<br>m</th><th>width<br>m</th><th>wall</th>"
      "<th>top</th><th>basal<br>perimeter</th><th>wall GSD<br>mm</th><th>basal GSD<br>mm</th><th>azimuth<br>bins</th>"
      "<th>sigma 95&nbsp;%<br>mm</th><th></th></tr></thead><tbody>");
  for (const CoverageTargetRow& t : page.targets) {
    h.raw("<tr><th>").text(t.label).raw("</th><td");
    h.attr("class", t.passed ? "good" : "bad").raw(">").text(t.passed ? "passes" : "fails: " + t.reasons);
    const auto cell = [&h](const std::string& text) { h.raw("</td><td class=\"n\">").text(text); };
    cell(fixed(t.height_m, 2));
    cell(fixed(t.width_m, 2));
    cell(percent(t.wall, 0));
    cell(percent(t.top, 0));
    cell(percent(t.basal, 0) + (t.contact_known ? "" : " *"));
    cell(or_dash(t.wall_gsd_mm, 1));
    cell(or_dash(t.basal_gsd_mm, 1));
    cell(std::to_string(t.azimuth_bins));
    cell(or_dash(t.sigma_mm, 1));
    h.raw("</td><td>");
    rose(h, t);
    h.raw("</td></tr>");
  }
  h.raw(
      "</tbody></table><p class=\"quiet\">* The contact is not known: the lowest part of the wall stands for it.</p>");
}

void frame_table(Html& h, const CoveragePage& page) {
  const bool any =
      std::any_of(page.frames.begin(), page.frames.end(), [](const auto& f) { return f.blur_px.has_value(); });
  if (!any) return;
  h.raw("<h2>Blur by the flight</h2><p>");
  h.text("Speed times exposure over the sampling distance along the optical axis; the limit is " +
         base::to_text(page.blur_limit_px) + "\u202fpx.");
  h.raw(
      "</p><table><thead><tr><th>frame</th><th>GSD<br>mm</th><th>speed<br>m/s</th><th>exposure<br>ms</th><th>blur<br>px"
      "</th></tr></thead><tbody>");
  for (const CoverageFrameRow& f : page.frames) {
    constexpr double kMilliseconds = 1000.0;
    std::optional<double> exposure;
    if (f.exposure_s) exposure = kMilliseconds * *f.exposure_s;
    h.raw("<tr><th>")
        .text(f.label)
        .raw("</th><td class=\"n\">")
        .text(or_dash(f.gsd_mm, 1))
        .raw("</td><td class=\"n\">");
    h.text(or_dash(f.speed_m_s, 1)).raw("</td><td class=\"n\">").text(or_dash(exposure, 2)).raw("</td><td");
    h.attr("class", f.blur_px && *f.blur_px > page.blur_limit_px ? "n bad" : "n").raw(">").text(or_dash(f.blur_px, 2));
    h.raw("</td></tr>");
  }
  h.raw("</tbody></table>");
}

void bar(Html& h, const std::string& name, const std::string& rule, double share, const std::string& text, bool good) {
  h.raw("<div class=\"share\"><span>").text(name).raw("</span><span class=\"quiet\">").text(rule).raw("</span><i><b");
  h.attr("class", good ? "good" : "fail");
  h.attr("style", "width:" + Html::short_number(100.0 * std::clamp(share, 0.0, 1.0), 2) + "%");
  h.raw("></b></i><span class=\"n\">").text(text).raw("</span></div>");
}

void gap_table(Html& h, const CoverageView& c) {
  if (c.gaps.empty()) return;
  h.raw(
      "<h2>Gaps</h2><p>Connected patches that fail for one reason, largest first.</p><table><thead><tr><th>gap</th>"
      "<th>area<br>m²</th><th>east<br>m</th><th>north<br>m</th><th>why</th><th>nearest frames</th><th>suggestion</th>"
      "</tr></thead><tbody>");
  for (std::size_t i = 0; i < std::min(kGapRows, c.gaps.size()); ++i) {
    const GapView& g = c.gaps[i];
    std::string reasons, frames;
    for (const std::string& r : g.reasons) reasons += (reasons.empty() ? "" : ", ") + words_of(r);
    for (const std::string& f : g.nearest_frames) frames += (frames.empty() ? "" : ", ") + f;
    h.raw("<tr><th>").text(std::to_string(g.id)).raw("</th><td class=\"n\">").text(fixed(g.area_m2, 1));
    h.raw("</td><td class=\"n\">").text(fixed(g.centroid.x(), 1)).raw("</td><td class=\"n\">");
    h.text(fixed(g.centroid.y(), 1)).raw("</td><td>").text(reasons).raw("</td><td class=\"quiet\">").text(frames);
    h.raw("</td><td class=\"quiet\">").text(g.suggestion).raw("</td></tr>");
  }
  h.raw("</tbody></table>");
  if (c.gaps.size() > kGapRows)
    h.raw("<p class=\"quiet\">")
        .text(std::to_string(c.gaps.size() - kGapRows) + " smaller ones are in the layer of gaps.")
        .raw("</p>");
}

void lead(Html& h, const CoveragePage& page) {
  const CoverageView& c = page.coverage;
  h.raw("<p class=\"lead\"><b>").text(percent(c.complete_fraction)).raw("</b>");
  std::string text = " of " + fixed(c.area_m2, 0) + "\u202fm² of observed surface passes every gate";
  if (c.interval_95)
    text += " (95\u202f% interval " + percent((*c.interval_95)[0]) + " to " + percent((*c.interval_95)[1]) +
            (page.block_m ? ", blocks of " + fixed(*page.block_m, 1) + "\u202fm" : "") + ")";
  text += ".";
  if (page.sides_complete)
    text += " Walls and undersides, " + fixed(page.sides_area_m2.value_or(0.0), 1) + "\u202fm², pass by " +
            percent(*page.sides_complete) + ".";
  h.text(text).raw(
      "</p><p class=\"quiet\">Predicted visibility: computed from poses, intrinsics and surface by ray casting. "
      "Shadow, blur, lack of texture and moving leaves are not in it.</p>");
}

}  // namespace

std::string render_coverage_page(const CoveragePage& page) {
  const CoverageView& c = page.coverage;
  Html h;
  h.raw(
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
      "http-equiv=\"Content-Security-Policy\" "
      "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; base-uri 'none'; form-action 'none'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>");
  h.text(page.title)
      .raw(
          "</title>\n<style>body{font:15px/1.45 system-ui,'Noto Sans','DejaVu Sans',sans-serif;margin:0 "
          "auto;max-width:1240px;"
          "padding:24px;color:#1c1c1c;background:#fff}h1{font-size:24px;margin:0 0 6px}h2{font-size:18px;margin:30px 0 "
          "8px}"
          "p{margin:4px "
          "0}.lead{font-size:17px}.quiet{color:#555;font-size:13px}svg{max-width:100%;height:auto;display:block}"
          ".maps{display:grid;grid-template-columns:repeat(auto-fit,minmax(360px,1fr));gap:20px}figure{margin:0}"
          ".map img{display:block;image-rendering:pixelated;border:1px solid "
          "#ccc;box-sizing:border-box;background:#f4f4f4}"
          ".keys{list-style:none;display:flex;flex-wrap:wrap;gap:2px 12px;margin:4px 0;padding:0;font-size:13px}.keys "
          "i{display:"
          "inline-block;width:14px;height:14px;margin-right:5px;vertical-align:-2px;border:1px solid "
          "#999}.charts{display:grid;"
          "grid-template-columns:repeat(auto-fit,minmax(340px,1fr));gap:16px}table{border-collapse:collapse;font-size:"
          "13.5px}"
          "th,td{padding:3px 9px;border-bottom:1px solid #ddd;text-align:left;vertical-align:middle}thead "
          "th{vertical-align:bottom;"
          "border-bottom:2px solid "
          "#888}.n{text-align:right;font-variant-numeric:tabular-nums}.share{display:grid;grid-template-columns:"
          "150px 260px 1fr 130px;gap:10px;align-items:center}.share "
          "i{background:#e9e9e9;height:12px;display:block}.bar "
          "b{display:block;"
          "height:12px}.share b.good{background:#2a788e}.bar "
          "b.fail{background:#c8a96a}td.good{color:#1b6b3a}td.bad{color:#a33a00}"
          ".rose{width:84px;height:84px}.histogram{width:100%;max-width:420px}.histogram text{fill:#555;font-size:10px}"
          ".histogram .label{fill:#1c1c1c;font-size:11px;font-weight:560}.histogram .mid{text-anchor:middle}.histogram "
          ".end{text-anchor:"
          "end}.histogram .grid{stroke:#ddd}.histogram .axis{stroke:#999}.histogram .bar{fill:#4c8598}.histogram "
          ".bar.fails{fill:#d9b48c}"
          ".histogram .gate{stroke:#a84a00;stroke-width:1.4}.histogram "
          ".gate-label{fill:#a84a00;font-weight:560}</style>\n</head>\n<body>\n<h1>");
  h.text(page.title).raw("</h1>\n");
  lead(h, page);
  for (const std::string& note : page.notes) h.raw("<p class=\"quiet\">").text(note).raw("</p>\n");
  double total = 0.0;
  for (const VerdictArea& v : c.verdicts) total += v.area_m2;
  if (total > 0.0) {
    h.raw("<h2>What becomes of the surface</h2>");
    for (const VerdictArea& v : c.verdicts)
      if (v.area_m2 > 0.0)
        bar(h, words_of(v.verdict), fixed(v.area_m2, 1) + "\u202fm²", v.area_m2 / total, percent(v.area_m2 / total),
            v.verdict == "passed");
  }
  if (!c.gates.empty()) {
    h.raw("<h2>Gates, each on its own</h2>");
    for (const Gate& g : c.gates)
      bar(h, words_of(g.name), g.rule, g.pass_fraction, percent(g.pass_fraction) + " pass", true);
  }
  if (!page.maps.empty()) {
    h.raw("<h2>Maps</h2><div class=\"maps\">");
    for (const CoverageMap& map : page.maps) map_figure(h, map);
    h.raw("</div>");
  }
  h.raw("<h2>Distribution</h2><div class=\"charts\">");
  for (const Histogram& histogram : c.histograms)
    if (histogram.areas_m2.size() + 1 == histogram.edges.size() && histogram.edges.size() > 1 &&
        histogram.edges.front() < histogram.edges.back())
      h.raw("<figure>").add(histogram_chart(histogram)).raw("</figure>");
  h.raw("</div><p class=\"quiet\">Share of the surface's area in each bin. Sand-coloured bars fail the gate.</p>");
  target_table(h, page);
  gap_table(h, c);
  frame_table(h, page);
  h.raw("\n</body>\n</html>\n");
  return std::move(h).str();
}

CoverageMap metric_map(const geometry::Grid<float>& values, const std::string& title, const std::string& note,
                       const std::string& unit, double lo, double hi, bool small_is_good) {
  constexpr int kColours = 200;
  const geometry::Grid<float> small = shrunk(values, kMapPixels, Merge::mean);
  CoverageMap map{title, note, {}, small.geometry, {}};
  map.image.width = small.geometry.columns;
  map.image.height = small.geometry.rows;
  const auto colour = [&](double t) { return cividis(small_is_good ? 1.0 - t : t); };
  map.image.palette.push_back({0, 0, 0, 0});
  for (int i = 0; i < kColours; ++i) map.image.palette.push_back(colour(i / (kColours - 1.0)));
  map.image.pixels.reserve(small.values.size());
  for (const float v : small.values) {
    const double t = hi > lo ? std::clamp((static_cast<double>(v) - lo) / (hi - lo), 0.0, 1.0) : 0.0;
    map.image.pixels.push_back(std::isnan(v) ? std::uint8_t{0}
                                             : static_cast<std::uint8_t>(1 + std::lround(t * (kColours - 1))));
  }
  constexpr int kKeys = 5;
  for (int i = 0; i < kKeys; ++i) {
    const double t = i / (kKeys - 1.0);
    const std::string more = i == 0 ? "≤ " : i == kKeys - 1 ? "≥ " : "";
    map.keys.push_back({colour(t), more + base::to_fixed(lo + t * (hi - lo), hi - lo < 10.0 ? 1 : 0) + " " + unit});
  }
  return map;
}

CoverageMap count_map(const geometry::Grid<float>& counts, const std::string& title, const std::string& note,
                      int most) {
  // The least of a block: a hole must not be averaged away.
  geometry::Grid<float> negative = counts;
  for (float& v : negative.values) v = -v;
  geometry::Grid<float> small = shrunk(negative, kMapPixels, Merge::maximum);
  for (float& v : small.values) v = -v;
  CoverageMap map{title, note, view_counts(small, most), small.geometry, {}};
  geometry::Grid<float> legend({0.0, 1.0, 1.0, static_cast<std::size_t>(most) + 1, 1}, 0.0F);
  for (int i = 0; i <= most; ++i) legend.values[static_cast<std::size_t>(i)] = static_cast<float>(i);
  const IndexedImage keys = view_counts(legend, most);
  for (int i = 0; i <= most; ++i)
    map.keys.push_back(
        {keys.palette[keys.pixels[static_cast<std::size_t>(i)]], std::to_string(i) + (i == most ? " and more" : "")});
  return map;
}

}  // namespace cairn::report
