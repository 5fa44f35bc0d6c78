// Where the figures come from, and how to read the page.
#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "report/definitions.hpp"
#include "report/sections.hpp"

namespace cairn::report {
namespace {

constexpr std::size_t kRejectRows = 200;  // listed one by one; run.json has all

}  // namespace

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
           fixed(o.position.height_m, 2) + "\u202fm (datum: " + words_of(survey::name_of(o.height_type)) +
           (o.geoid.empty() ? "" : ", " + o.geoid) + ")");
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
    std::map<std::pair<std::string, std::string>, std::vector<const StageReject*>> groups;
    for (const StageReject& r : d.rejects) groups[{r.stage, r.reject.reason}].push_back(&r);
    h.raw("<h3>Rejected records</h3><div class=\"table-frame\"><table class=\"plain\"><thead><tr><th>stage</th>")
        .raw("<th>reason</th><th>meaning</th><th class=\"n\">records</th></tr></thead><tbody>");
    for (const auto& [key, records] : groups) {
      // A code without a sentence of its own is explained by its first record.
      std::string meaning = reason_sentence(key.second);
      if (meaning == words_of(key.second)) meaning = "For example: " + records.front()->reject.message;
      h.raw("<tr><th scope=\"row\">").text(key.first).raw("</th><td><code>").text(key.second).raw("</code></td><td>");
      h.text(meaning).raw("</td><td class=\"n\">").text(grouped(records.size())).raw("</td></tr>");
    }
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
