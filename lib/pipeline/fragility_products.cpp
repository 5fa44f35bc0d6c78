#include "pipeline/fragility_products.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "base/angle.hpp"
#include "base/atomic_file.hpp"
#include "base/number_text.hpp"
#include "fragility/draw_summary.hpp"
#include "io/tipping_json.hpp"

namespace cairn::pipeline {
namespace {

using base::rad_to_deg;
using geometry::Vec3;

io::Json matrix_json(const geometry::Mat3& m) {
  io::Json rows = io::Json::array();
  for (int r = 0; r < 3; ++r) rows.push(std::vector<double>{m(r, 0), m(r, 1), m(r, 2)});
  return rows;
}

template <typename Points>
io::Json points_json(const Points& points) {
  io::Json list = io::Json::array();
  for (const auto& p : points) list.push(io::Json(Vec3(p)));
  return list;
}

// null where the value is absent or infinite.
io::Json degrees(const std::optional<double>& rad) {
  return rad ? io::Json(rad_to_deg(*rad)) : io::Json();
}

io::Json edge_json(const survey::TippingEdge& e, double mass) {
  return io::Json::object({{"ends_m", points_json(e.ends)},
                           {"topple_toward_deg", e.azimuth_deg},
                           {"inclination_deg", rad_to_deg(e.inclination_rad)},
                           {"alpha_deg", rad_to_deg(e.alpha_rad)},
                           {"r_m", e.r_m},
                           {"inertia_kg_m2", e.inertia_m2 * mass},
                           {"p_rad_s", e.p_rad_s},
                           {"a_qs_g", e.a_qs_g},
                           {"v_min_m_s", e.v_min_m_s},
                           {"barrier_j", e.barrier_j_kg * mass},
                           {"critical_share", e.critical_share}});
}

io::Json pad_number(double value) {
  return static_cast<std::int64_t>(value);
}
io::Json gap_width(double value) {
  return value;
}

io::Json variants_json(const std::vector<survey::TippingVariant>& variants, const std::string& key,
                       io::Json (*number)(double)) {
  io::Json list = io::Json::array();
  for (const auto& v : variants)
    list.push(io::Json::object({{key, number(v.value)},
                                {"alpha_min_deg", degrees(v.alpha_rad)},
                                {"topple_toward_deg", v.azimuth_deg ? io::Json(*v.azimuth_deg) : io::Json()},
                                {"reason", v.reason}}));
  return list;
}

io::Json views_json(const std::vector<survey::PhotoView>& views) {
  io::Json list = io::Json::array();
  for (const auto& v : views)
    list.push(io::Json::object({{"view_azimuth_deg", v.view_azimuth_deg},
                                {"alpha_left_deg", rad_to_deg(v.alpha_left_rad)},
                                {"alpha_right_deg", rad_to_deg(v.alpha_right_rad)},
                                {"r_left_m", v.r_left_m},
                                {"r_right_m", v.r_right_m}}));
  return list;
}

io::Json bound_json(const std::optional<survey::TippingBound>& bound) {
  if (!bound) return {};
  auto json = io::Json::object({{"contact", bound->contact}, {"reason", bound->reason}});
  json.set("alpha_min_deg", bound->critical ? io::Json(rad_to_deg(bound->critical->alpha_rad)) : io::Json());
  json.set("topple_toward_deg", bound->critical ? io::Json(bound->critical->azimuth_deg) : io::Json());
  json.set("a_qs_g", bound->critical ? io::Json(bound->critical->a_qs_g) : io::Json());
  return json;
}

io::Json interval_json(const survey::Tipping& t) {
  const auto end = [](const std::optional<survey::TippingBound>& b) {
    return b && b->critical ? io::Json(rad_to_deg(b->critical->alpha_rad)) : io::Json();
  };
  io::Json interval = io::Json::array();
  interval.push(end(t.inner));
  interval.push(end(t.outer));
  return interval;
}

io::Json uncertainty_json(const survey::TippingUncertainty& u) {
  return io::Json::object({{"draws", u.draws},
                           {"standing", u.standing},
                           {"slides_first_share", u.slides_first_share},
                           {"rose", u.rose},
                           {"variance_shares", io::named_values_to_json(u.variance_shares)},
                           {"variance_shares_bearing", io::named_values_to_json(u.variance_shares_bearing)},
                           {"inputs", io::named_values_to_json(u.inputs)},
                           {"draws_file", u.draws_file}});
}

void set_tipping(io::Json& json, const survey::Rock& rock, const std::string& north) {
  const auto& t = rock.tipping;
  const auto& edge = *t.critical;
  json.set("alpha_min_deg", rad_to_deg(edge.alpha_rad));
  json.set("alpha_interval_deg", interval_json(t));
  json.set("alpha_inner", bound_json(t.inner));
  json.set("alpha_outer", bound_json(t.outer));
  json.set("azimuth_deg", edge.azimuth_deg);
  json.set("topple_toward_deg", edge.azimuth_deg);
  json.set("azimuth_from", north);
  json.set("r_m", edge.r_m);
  json.set("p_rad_s", edge.p_rad_s);
  json.set("a_qs_g", edge.a_qs_g);
  json.set("v_min_m_s", edge.v_min_m_s);
  json.set("barrier_j", edge.barrier_j_kg * rock.density_kg_m3 * rock.mass->volume);
  json.set("alpha_point_deg", rad_to_deg(t.alpha_point_rad));
  json.set("a_qs_min_g", t.a_qs_min_g);
  json.set("a_qs_min_toward_deg", t.a_qs_min_azimuth_deg);
  json.set("friction", t.friction);
  json.set("slides_first", t.slides_first);
  json.set("a_qs_g_by_azimuth", t.a_qs_g_by_azimuth);
  json.set("without_pad", variants_json(t.without_pad, "pad", pad_number));
  json.set("by_gap", variants_json(t.gaps, "gap_m", gap_width));
  json.set("photo_views", views_json(t.photo_views));
  if (!t.uncertainty) return;
  io::Json quantiles = io::Json::object();
  for (const auto& s : t.uncertainty->scalars) quantiles.set(s.name, io::to_json(s.value));
  json.set("quantiles", std::move(quantiles));
  json.set("uncertainty", uncertainty_json(*t.uncertainty));
}

// Seven significant digits: the spread of draws is far above that, and the files stay small.
void append(std::string& text, double value) {
  if (!std::isfinite(value)) return;
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 7);
  text.append(buffer.data(), end.ptr);
}

}  // namespace

io::Json rock_summary(const survey::Rock& rock, const std::string& name, const std::string& north) {
  const auto& mass = *rock.mass;
  const double density = rock.density_kg_m3;
  const auto& tip = rock.tipping;
  auto json = io::Json::object({{"id", rock.target.value},
                                {"name", name},
                                {"grade", survey::name_of(tip.grade)},
                                {"reasons", io::Json(tip.reasons)},
                                {"notes", io::Json(rock.reasons)},
                                {"volume_m3", mass.volume},
                                {"hull_volume_m3", rock.hull_volume_m3},
                                {"density_kg_m3", density},
                                {"density_assumed", rock.density_assumed},
                                {"mass_kg", density * mass.volume},
                                {"com_m", io::Json(mass.centre_of_mass)},
                                {"inertia_kg_m2", matrix_json(density * mass.inertia_per_density)},
                                {"ratios", io::named_values_to_json(rock.shape_ratios)},
                                {"contact", points_json(tip.contact)},
                                {"contact_assumed", tip.contact_assumed},
                                {"contact_observed_share", tip.contact_observed_share},
                                {"contact_pads", tip.contact_pads},
                                {"contact_slope_deg", rad_to_deg(tip.contact_slope_rad)},
                                {"contact_aspect_deg", tip.contact_aspect_deg}});
  if (tip.rolling)
    json.set("rolling", io::Json::object({{"height_m", tip.rolling->height_m},
                                          {"rock_curvature_1_m", tip.rolling->rock_curvature_1_m},
                                          {"pedestal_curvature_1_m", tip.rolling->pedestal_curvature_1_m},
                                          {"stable", tip.rolling->stable}}));
  if (tip.critical) set_tipping(json, rock, north);
  return json;
}

io::Json tipping_detail(const survey::Rock& rock, const fragility::Assessment& assessment) {
  const auto& detail = assessment.detail;
  const auto& tip = rock.tipping;
  const double mass = rock.density_kg_m3 * rock.mass->volume;
  io::Json edges = io::Json::array();
  for (const auto& e : tip.edges) edges.push(edge_json(e, mass));
  return io::Json::object({{"schema_version", 1},
                           {"id", rock.target.value},
                           {"grade", survey::name_of(tip.grade)},
                           {"reasons", io::Json(tip.reasons)},
                           {"definition", "edge: rotation about an edge of the hull of the contact"},
                           {"inertia_sign", "off-diagonals are -Int xy dm"},
                           {"density_kg_m3", rock.density_kg_m3},
                           {"density_assumed", rock.density_assumed},
                           {"critical_edge", static_cast<std::int64_t>(*detail.critical)},
                           {"edges", std::move(edges)},
                           {"plumb_margin_m", detail.plumb_margin},
                           {"alpha_point_deg", rad_to_deg(detail.alpha_point)},
                           {"a_qs_min_g", detail.a_qs_min_g},
                           {"a_qs_min_toward_deg", detail.a_qs_min_azimuth_deg},
                           {"a_qs_g_by_azimuth", detail.a_qs_g_by_azimuth},
                           {"tipping", io::to_json(tip)}});
}

void write_draws(const std::filesystem::path& path, const std::vector<fragility::TippingDraw>& draws) {
  std::string text = "draw,standing";
  for (const auto& column : fragility::draw_columns()) text += "," + std::string(column.name);
  text += ",alpha_bearing_deg,bearing_inset\n";
  for (std::size_t k = 0; k < draws.size(); ++k) {
    const auto& d = draws[k];
    text += std::to_string(k) + (d.standing ? ",1" : ",0");
    for (const auto& column : fragility::draw_columns()) {
      text += ',';
      if (d.standing || !column.needs_standing) append(text, column.value(d));
    }
    text += ',';
    if (d.alpha_bearing) append(text, rad_to_deg(*d.alpha_bearing));
    text += ',';
    append(text, d.bearing_inset);
    text += '\n';
  }
  base::write_file(path, text);
}

}  // namespace cairn::pipeline
