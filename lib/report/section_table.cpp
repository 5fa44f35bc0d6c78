// The table of objects: one row a target, the rock's figures beside it.
#include <array>
#include <cmath>
#include <optional>

#include "base/angle.hpp"
#include "base/number_text.hpp"
#include "report/definitions.hpp"
#include "report/sections.hpp"

namespace cairn::report {
namespace {

struct Column {
  std::string_view key, label, unit, hint;
  std::string_view group;
};

constexpr std::array kColumns{
    Column{"id", "id", "", "Persistent number of the object", "Object"},
    Column{"class", "class", "", "As the detector named it", "Object"},
    Column{"state", "state", "", "How far the localisation got", "Object"},
    Column{"grade", "grade", "", "How far the tipping figures can be trusted", "Tipping of the rock"},
    Column{"alpha_deg", "α", "°", "Least tipping angle; blank where the grade allows none", "Tipping of the rock"},
    Column{"topple_toward_deg", "toward", "°", "Azimuth of toppling, clockwise from true north", "Tipping of the rock"},
    Column{"a_qs_g", "a_qs", "g", "Quasi-static tipping acceleration toward that azimuth", "Tipping of the rock"},
    Column{"length_m", "L", "m", "Longer side seen from above", "Body of the rock"},
    Column{"width_m", "W", "m", "Shorter side seen from above", "Body of the rock"},
    Column{"height_m", "H", "m", "Height above the ground beside it", "Body of the rock"},
    Column{"volume_m3", "V", "m³", "Volume of the closed surface", "Body of the rock"},
    Column{"points", "points", "", "Points of the cloud on the rock", "Body of the rock"},
    Column{"boxes", "boxes", "", "Detections that belong to the object", "Position"},
    Column{"sigma_horizontal_m", "σ horiz.", "m", "One sigma of the horizontal position", "Position"},
    Column{"sigma_up_m", "σ up", "m", "One sigma of the height", "Position"},
    Column{"east_m", "east", "m", "Local frame", "Position"},
    Column{"north_m", "north", "m", "Local frame", "Position"},
    Column{"up_m", "up", "m", "Local frame", "Position"},
    Column{"latitude_deg", "latitude", "°", "WGS 84", "Position"},
    Column{"longitude_deg", "longitude", "°", "WGS 84", "Position"},
};

void number(Html& h, std::optional<double> value, int decimals) {
  if (!value || !std::isfinite(*value)) {
    h.raw("<td class=\"n none\"></td>");
    return;
  }
  h.raw("<td class=\"n\"").attr("data-v", base::to_text(*value)).raw(">").text(fixed(*value, decimals)).raw("</td>");
}

void head(Html& h) {
  h.raw("<thead><tr class=\"groups\">");
  for (std::size_t i = 0; i < kColumns.size();) {
    std::size_t n = 1;
    while (i + n < kColumns.size() && kColumns[i + n].group == kColumns[i].group) ++n;
    h.raw("<th scope=\"colgroup\"").attr("colspan", std::to_string(n)).raw(">").text(kColumns[i].group).raw("</th>");
    i += n;
  }
  h.raw("</tr><tr class=\"columns\">");
  for (const Column& c : kColumns) {
    h.raw("<th scope=\"col\"").attr("data-key", c.key).attr("title", c.hint).raw(">").symbol(c.label);
    if (!c.unit.empty()) h.raw("<small>").text(c.unit).raw("</small>");
    h.raw("</th>");
  }
  h.raw("</tr></thead>");
}

void row(Html& h, const PageContext& page, const survey::Target& t) {
  const RockView* view = page.rock(t.id);
  const survey::Rock* rock = view == nullptr || view->rock.rejected ? nullptr : &view->rock;
  const bool allowed =
      rock != nullptr && rock->tipping.grade != survey::Grade::not_measurable && rock->tipping.critical;
  const std::string grade = view == nullptr       ? ""
                            : view->rock.rejected ? "not_cut"
                                                  : std::string(survey::name_of(rock->tipping.grade));
  const std::string id = std::to_string(t.id.value);
  h.raw("<tr").attr("data-id", id).attr("data-class", t.object_class).attr("data-state", survey::name_of(t.state));
  h.attr("data-grade", grade)
      .raw("><th scope=\"row\" class=\"n\"")
      .attr("data-v", id)
      .raw("><a")
      .attr("href", "#object-" + id);
  h.raw(">")
      .text(id)
      .raw("</a></th><td>")
      .add(class_symbol(page, t.object_class))
      .text(words_of(t.object_class))
      .raw("</td><td class=\"quiet\">");
  h.text(survey::name_of(t.state)).raw("</td><td>");
  if (rock != nullptr) {
    h.add(grade_badge(rock->tipping.grade));
  } else if (view != nullptr) {
    std::string why;
    for (const std::string& code : view->rock.reasons) why += (why.empty() ? "" : " ") + reason_sentence(code);
    h.raw("<span class=\"badge not-cut\"").attr("title", why).raw(">not cut</span>");
  }
  h.raw("</td>");
  const auto if_allowed = [&](auto&& get) {
    return allowed ? std::optional<double>(get(*rock->tipping.critical)) : std::nullopt;
  };
  number(h, if_allowed([](const survey::TippingEdge& e) { return base::rad_to_deg(e.alpha_rad); }), 1);
  number(h, if_allowed([](const survey::TippingEdge& e) { return e.azimuth_deg; }), 0);
  number(h, if_allowed([](const survey::TippingEdge& e) { return e.a_qs_g; }), 3);
  const auto if_cut = [&](auto&& get) { return rock != nullptr ? std::optional<double>(get(*rock)) : std::nullopt; };
  number(h, if_cut([](const survey::Rock& r) { return r.size_m.x(); }), 2);
  number(h, if_cut([](const survey::Rock& r) { return r.size_m.y(); }), 2);
  number(h, if_cut([](const survey::Rock& r) { return r.size_m.z(); }), 2);
  number(h,
         rock != nullptr && rock->mass && rock->cap != survey::CapModel::none ? std::optional(rock->mass->volume)
                                                                              : std::nullopt,
         3);
  number(h, if_cut([](const survey::Rock& r) { return static_cast<double>(r.point_count); }), 0);
  number(h, static_cast<double>(t.detections.size()), 0);
  // A rock found in the cloud alone has no covariance.
  const bool located = !t.covariance.isZero(0.0);
  number(h, located ? std::optional(horizontal_sigma(t.covariance)) : std::nullopt, 3);
  number(h, located ? std::optional(std::sqrt(std::max(0.0, t.covariance(2, 2)))) : std::nullopt, 3);
  for (Eigen::Index k = 0; k < 3; ++k) number(h, t.centre[k], 2);
  const geometry::Geodetic g = page.frame.to_geodetic(t.centre);
  number(h, g.latitude_deg, 7);
  number(h, g.longitude_deg, 7);
  h.raw("</tr>");
}

}  // namespace

Html table_section(const PageContext& page) {
  Html h;
  if (page.data.targets.empty()) return h;
  h.raw(
      "<section id=\"objects\"><div class=\"section-head\"><h2>Objects and rocks</h2><div class=\"table-tools\" "
      "hidden></div></div>"
      "<div class=\"table-frame\" tabindex=\"0\"><table class=\"objects\"><caption>");
  h.text(plural(page.data.targets.size(), "object", "objects") +
         ". Units stand under the column names. A blank tipping figure means that the grade allows none.");
  h.raw("</caption>");
  head(h);
  h.raw("<tbody>");
  for (const TargetView& t : page.data.targets) row(h, page, t.target);
  h.raw("</tbody></table></div></section>");
  return h;
}

}  // namespace cairn::report
