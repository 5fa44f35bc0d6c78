// One article for each located object; the script shows the selected one beside the map.
#include <cmath>

#include "base/angle.hpp"
#include "report/base64.hpp"
#include "report/charts.hpp"
#include "report/definitions.hpp"
#include "report/sections.hpp"

namespace cairn::report {
namespace {

void fact(Html& h, std::string_view name, const std::string& value, std::string_view unit, std::string_view note = {}) {
  h.raw("<div><dt>").symbol(name).raw("</dt><dd>").text(value);
  if (!unit.empty()) h.raw("<span class=\"unit\">").text(unit).raw("</span>");
  if (!note.empty()) h.raw("<small>").text(note).raw("</small>");
  h.raw("</dd></div>");
}

void reasons(Html& h, const std::vector<std::string>& codes) {
  if (codes.empty()) return;
  h.raw("<ul class=\"reasons\">");
  for (const std::string& code : codes)
    h.raw("<li>").text(reason_sentence(code)).raw(" <code>").text(code).raw("</code></li>");
  h.raw("</ul>");
}

void tipping(Html& h, const survey::Rock& rock) {
  const survey::Tipping& t = rock.tipping;
  h.raw("<section class=\"tipping\"><h4>Tipping</h4>");
  // The gate of the whole report: below it nothing of the tipping figures may be written.
  if (t.grade == survey::Grade::not_measurable || !t.critical) {
    h.raw(
        "<div class=\"withheld\"><p><b>No tipping figure is given.</b> Too little was seen of the rock or of its "
        "contact:</p>");
    reasons(h, t.reasons);
    h.raw("</div></section>");
    return;
  }
  const survey::TippingEdge& e = *t.critical;
  const bool screening = t.grade == survey::Grade::screening;
  h.raw("<p class=\"grade-note\">").text(grade_meaning(t.grade)).raw("</p><div class=\"tipping-body\">");
  if (t.a_qs_g_by_azimuth.size() == 360) {
    h.raw("<figure class=\"polar-figure\">")
        .add(polar_chart(t.a_qs_g_by_azimuth, e.azimuth_deg))
        .raw("<figcaption>a<sub>qs</sub> [g] toward each azimuth</figcaption></figure>");
  }
  h.raw("<dl class=\"facts\">");
  const std::string qualifier = screening ? "screening value" : t.grade == survey::Grade::bounded ? "limit" : "";
  fact(h, "Least tipping angle α", fixed(base::rad_to_deg(e.alpha_rad), 1), "°", qualifier);
  fact(h, "Toppling toward", fixed(e.azimuth_deg, 0), "° from north");
  fact(h, "a_qs there", fixed(e.a_qs_g, 3), "g", "quasi-static");
  fact(h, "v_min there", fixed(e.v_min_m_s, 2), "m/s");
  fact(h, "R to the edge", fixed(e.r_m, 3), "m");
  fact(h, "p", fixed(e.p_rad_s, 2), "rad/s");
  h.raw("</dl></div>");
  reasons(h, t.reasons);
  h.raw("</section>");
}

void rock_body(Html& h, const RockView& view) {
  const survey::Rock& r = view.rock;
  if (r.rejected) {
    h.raw("<section><h4>Not cut from the cloud</h4>");
    reasons(h, r.reasons);
    h.raw("</section>");
    return;
  }
  if (view.mesh && !view.mesh->triangles.empty()) {
    h.raw("<div class=\"scene\"").attr("data-rock", std::to_string(r.target.value)).raw("><p class=\"scene-note\">");
    h.text("The 3-D view of the surface (" + grouped(view.mesh->triangles.size()) +
           " triangles) needs the script of this page.");
    if (!view.model_file.empty()) h.raw(" The model is in ").raw("<code>").text(view.model_file).raw("</code>.");
    h.raw("</p></div>");
  }
  tipping(h, r);
  h.raw("<section><h4>Body</h4><dl class=\"facts\">");
  fact(h, "Length × width × height",
       fixed(r.size_m.x(), 2) + " × " + fixed(r.size_m.y(), 2) + " × " + fixed(r.size_m.z(), 2), "m",
       "long side toward " + fixed(r.length_azimuth_deg, 0) + "°");
  if (r.mass && r.cap != survey::CapModel::none) {
    fact(h, "Volume", fixed(r.mass->volume, 3), "m³",
         std::string(cap_meaning(r.cap)) + "; hull " + fixed(r.hull_volume_m3, 3) + "\u202fm³");
    if (r.density_kg_m3 > 0.0)
      fact(h, "Mass", fixed(r.mass->volume * r.density_kg_m3, 0), "kg",
           "density " + fixed(r.density_kg_m3, 0) + "\u202fkg/m³" + (r.density_assumed ? ", assumed" : ""));
  }
  fact(h, "Surface not seen", fixed(100.0 * r.unseen_area_fraction, 0), "%", "of the closed surface, filled in");
  fact(h, "Points", grouped(r.point_count), "", "median spacing " + fixed(r.point_spacing_m, 3) + "\u202fm");
  if (r.size_m.y() > 0.0)
    fact(h, "Height / width", fixed(r.size_m.z() / r.size_m.y(), 2), "", "of the box, not of the contact");
  h.raw("</dl></section>");
}

void photos(Html& h, const PageContext& page, const TargetView& view) {
  if (!page.options.photos || view.photos.empty()) return;
  h.raw("<section><h4>Photographs</h4><div class=\"photos\">");
  for (const Photo& photo : view.photos) {
    if (photo.media_type != "image/jpeg" && photo.media_type != "image/png" && photo.media_type != "image/webp")
      continue;
    h.raw("<figure><img loading=\"lazy\"")
        .attr("alt", photo.caption)
        .raw(" src=\"data:")
        .text(photo.media_type)
        .raw(";base64,")
        .made(base64(photo.bytes))
        .raw("\"><figcaption>")
        .text(photo.caption)
        .raw("</figcaption></figure>");
  }
  h.raw("</div></section>");
}

void position(Html& h, const PageContext& page, const survey::Target& t) {
  const geometry::Geodetic g = page.frame.to_geodetic(t.centre);
  h.raw("<section><h4>Position</h4><dl class=\"facts\">");
  fact(h, "Local east, north, up",
       fixed(t.centre.x(), 3) + ", " + fixed(t.centre.y(), 3) + ", " + fixed(t.centre.z(), 3), "m");
  fact(h, "Latitude, longitude", latitude_text(g.latitude_deg) + ", " + longitude_text(g.longitude_deg), "");
  const double sigma_up = std::sqrt(std::max(0.0, t.covariance(2, 2)));
  fact(h, "Uncertainty, one sigma",
       fixed(horizontal_sigma(t.covariance), 3) + " horizontal, " + fixed(sigma_up, 3) + " up", "m",
       "from the rays; shared pose error not included");
  fact(h, "Seen in", plural(t.detections.size(), "box", "boxes"), "",
       plural(t.keyframes.size(), "keyframe", "keyframes") + ", mean score " + fixed(t.mean_score, 2));
  if (t.bcylinder)
    fact(h, "Bounding cylinder",
         fixed(t.bcylinder->radius, 2) + " radius, " + fixed(t.bcylinder->height(), 2) + " high", "m");
  h.raw("</dl>");
  const Html line = spark_line(t.entropy_nats, "Differential entropy after each keyframe");
  if (!line.empty())
    h.raw("<figure class=\"spark-figure\">")
        .add(line)
        .raw("<figcaption>")
        .text("Differential entropy after each keyframe: " + fixed(t.entropy_nats.front(), 1) + " to " +
              fixed(t.entropy_nats.back(), 1) + " nats (falling = the estimate settles)")
        .raw("</figcaption></figure>");
  h.raw("</section>");
}

}  // namespace

Html object_panel(const PageContext& page) {
  Html h;
  h.raw(
      "<div class=\"panel\" id=\"panel\"><div class=\"panel-empty\" hidden><p>Select an object on the map or in the "
      "table.</p></div>");
  for (const TargetView& view : page.data.targets) {
    const survey::Target& t = view.target;
    const std::string id = std::to_string(t.id.value);
    const RockView* rock = page.rock(t.id);
    h.raw("<article class=\"object\"").attr("id", "object-" + id).attr("data-id", id).raw("><header><h3>");
    h.add(class_symbol(page, t.object_class))
        .text(words_of(t.object_class))
        .raw(" <span>")
        .text(id)
        .raw("</span></h3><p class=\"badges\">");
    h.raw("<span class=\"badge state\"")
        .attr("title", state_meaning(t.state))
        .raw(">")
        .text(survey::name_of(t.state))
        .raw("</span>");
    if (rock != nullptr) {
      if (rock->rock.rejected) h.raw("<span class=\"badge not-cut\" title=\"Not cut from the cloud\">not cut</span>");
      else h.add(grade_badge(rock->rock.tipping.grade));
    }
    h.raw("</p></header>");
    if (rock != nullptr) rock_body(h, *rock);
    position(h, page, t);
    if (!t.reasons.empty()) {
      h.raw("<section><h4>Why this state</h4>");
      reasons(h, t.reasons);
      h.raw("</section>");
    }
    photos(h, page, view);
    h.raw("</article>");
  }
  h.raw("</div>");
  return h;
}

}  // namespace cairn::report
