#include "io/tipping_json.hpp"

#include <limits>
#include <string_view>
#include <utility>

#include "io/records_json.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::array<std::string_view, 5> kLevels{"p05", "p16", "p50", "p84", "p95"};

// The line of a steep edge may pass above the centre of mass: no push along its normal topples about it.
Json real_or_never(double value, std::string_view name) {
  return value == std::numeric_limits<double>::infinity() ? Json() : Json(finite(value, name));
}
double real_or_never(const Json& json) {
  return json.is_null() ? std::numeric_limits<double>::infinity() : json.as_real();
}

double real_or(const Json& json, std::string_view key, double otherwise) {
  const Json* found = json.find(key);
  return found == nullptr ? otherwise : found->as_real();
}
const Json* member(const Json& json, std::string_view key) {
  const Json* found = json.find(key);
  return found == nullptr || found->is_null() ? nullptr : found;
}
std::optional<double> maybe_real(const Json& json, std::string_view key) {
  const Json* found = member(json, key);
  return found == nullptr ? std::nullopt : std::optional<double>(found->as_real());
}
Json maybe_real(const std::optional<double>& value, std::string_view name) {
  return value ? Json(finite(*value, name)) : Json();
}

template <typename List, typename Make>
Json list_of(const List& list, Make&& make) {
  Json out = Json::array();
  for (const auto& item : list) out.push(make(item));
  return out;
}
template <typename Item, typename Make>
std::vector<Item> items_of(const Json& json, std::string_view key, Make&& make) {
  std::vector<Item> out;
  if (const Json* found = member(json, key))
    for (const auto& item : found->as_array()) out.push_back(make(item));
  return out;
}

Json edge_to_json(const survey::TippingEdge& e) {
  return Json::object({{"topple_toward_deg", finite(e.azimuth_deg, "topple_toward_deg")},
                       {"alpha_rad", finite(e.alpha_rad, "alpha_rad")},
                       {"r_m", finite(e.r_m, "r_m")},
                       {"p_rad_s", finite(e.p_rad_s, "p_rad_s")},
                       {"a_qs_g", real_or_never(e.a_qs_g, "a_qs_g")},
                       {"v_min_m_s", real_or_never(e.v_min_m_s, "v_min_m_s")},
                       {"inclination_rad", finite(e.inclination_rad, "inclination_rad")},
                       {"inertia_m2", finite(e.inertia_m2, "inertia_m2")},
                       {"barrier_j_kg", finite(e.barrier_j_kg, "barrier_j_kg")},
                       {"ends_m", list_of(e.ends, [](const geometry::Vec3& p) { return vec3_to_json(p, "ends_m"); })},
                       {"critical_share", finite(e.critical_share, "critical_share")}});
}

survey::TippingEdge edge_from_json(const Json& json) {
  survey::TippingEdge e;
  e.azimuth_deg = json.at("topple_toward_deg").as_real();
  e.alpha_rad = json.at("alpha_rad").as_real();
  e.r_m = json.at("r_m").as_real();
  e.p_rad_s = json.at("p_rad_s").as_real();
  e.a_qs_g = real_or_never(json.at("a_qs_g"));
  e.v_min_m_s = real_or_never(json.at("v_min_m_s"));
  e.inclination_rad = real_or(json, "inclination_rad", 0.0);
  e.inertia_m2 = real_or(json, "inertia_m2", 0.0);
  e.barrier_j_kg = real_or(json, "barrier_j_kg", 0.0);
  if (const Json* ends = member(json, "ends_m")) {
    if (ends->size() != 2)
      throw Error(ErrorCode::invalid_input, "an edge has two ends").found(std::to_string(ends->size()));
    e.ends = {ends->as_array()[0].as_vec3(), ends->as_array()[1].as_vec3()};
  }
  e.critical_share = real_or(json, "critical_share", 0.0);
  return e;
}

Json maybe_edge(const std::optional<survey::TippingEdge>& edge) {
  return edge ? edge_to_json(*edge) : Json();
}
std::optional<survey::TippingEdge> maybe_edge(const Json& json, std::string_view key) {
  const Json* found = member(json, key);
  return found == nullptr ? std::nullopt : std::optional(edge_from_json(*found));
}

survey::Quantiles quantiles_from_json(const Json& json) {
  return {real_or_never(json.at("p05")), real_or_never(json.at("p16")), real_or_never(json.at("p50")),
          real_or_never(json.at("p84")), real_or_never(json.at("p95"))};
}

Json bound_to_json(const std::optional<survey::TippingBound>& bound) {
  if (!bound) return {};
  return Json::object({{"contact", bound->contact},
                       {"reason", bound->reason},
                       {"critical", maybe_edge(bound->critical)},
                       {"a_qs_g_by_azimuth", finite_list(bound->a_qs_g_by_azimuth, "a_qs_g_by_azimuth")}});
}
std::optional<survey::TippingBound> bound_from_json(const Json& json, std::string_view key) {
  const Json* found = member(json, key);
  if (found == nullptr) return std::nullopt;
  survey::TippingBound bound;
  bound.contact = found->at("contact").as_string();
  bound.reason = found->at("reason").as_string();
  bound.critical = maybe_edge(*found, "critical");
  bound.a_qs_g_by_azimuth = real_list(found->at("a_qs_g_by_azimuth"));
  return bound;
}

Json variant_to_json(const survey::TippingVariant& v) {
  return Json::object({{"name", v.name},
                       {"value", finite(v.value, "value")},
                       {"reason", v.reason},
                       {"alpha_rad", maybe_real(v.alpha_rad, "alpha_rad")},
                       {"topple_toward_deg", maybe_real(v.azimuth_deg, "topple_toward_deg")}});
}
survey::TippingVariant variant_from_json(const Json& json) {
  return {json.at("name").as_string(), json.at("value").as_real(), json.at("reason").as_string(),
          maybe_real(json, "alpha_rad"), maybe_real(json, "topple_toward_deg")};
}

Json view_to_json(const survey::PhotoView& v) {
  return Json::object({{"view_azimuth_deg", finite(v.view_azimuth_deg, "view_azimuth_deg")},
                       {"alpha_left_rad", finite(v.alpha_left_rad, "alpha_left_rad")},
                       {"alpha_right_rad", finite(v.alpha_right_rad, "alpha_right_rad")},
                       {"r_left_m", finite(v.r_left_m, "r_left_m")},
                       {"r_right_m", finite(v.r_right_m, "r_right_m")}});
}
survey::PhotoView view_from_json(const Json& json) {
  return {json.at("view_azimuth_deg").as_real(), json.at("alpha_left_rad").as_real(),
          json.at("alpha_right_rad").as_real(), json.at("r_left_m").as_real(), json.at("r_right_m").as_real()};
}

Json rolling_to_json(const std::optional<survey::RollingContact>& r) {
  if (!r) return {};
  return Json::object({{"height_m", finite(r->height_m, "height_m")},
                       {"rock_curvature_1_m", finite(r->rock_curvature_1_m, "rock_curvature_1_m")},
                       {"pedestal_curvature_1_m", finite(r->pedestal_curvature_1_m, "pedestal_curvature_1_m")},
                       {"stable", r->stable}});
}
std::optional<survey::RollingContact> rolling_from_json(const Json& json) {
  const Json* found = member(json, "rolling");
  if (found == nullptr) return std::nullopt;
  return survey::RollingContact{found->at("height_m").as_real(), found->at("rock_curvature_1_m").as_real(),
                                found->at("pedestal_curvature_1_m").as_real(), found->at("stable").as_bool()};
}

Json uncertainty_to_json(const std::optional<survey::TippingUncertainty>& u) {
  if (!u) return {};
  Json scalars = Json::object();
  for (const auto& s : u->scalars) scalars.set(s.name, to_json(s.value));
  Json azimuths = Json::object();
  for (std::size_t i = 0; i < kLevels.size(); ++i)
    azimuths.set(std::string(kLevels[i]), finite_list(u->a_qs_g_by_azimuth[i], "a_qs_g_by_azimuth"));
  return Json::object({{"draws", u->draws},
                       {"standing", u->standing},
                       {"slides_first_share", finite(u->slides_first_share, "slides_first_share")},
                       {"scalars", std::move(scalars)},
                       {"a_qs_g_by_azimuth", std::move(azimuths)},
                       {"rose", finite_list(u->rose, "rose")},
                       {"variance_shares", named_values_to_json(u->variance_shares)},
                       {"variance_shares_bearing", named_values_to_json(u->variance_shares_bearing)},
                       {"inputs", named_values_to_json(u->inputs)},
                       {"draws_file", u->draws_file}});
}
std::optional<survey::TippingUncertainty> uncertainty_from_json(const Json& json) {
  const Json* found = member(json, "uncertainty");
  if (found == nullptr) return std::nullopt;
  survey::TippingUncertainty u;
  u.draws = found->at("draws").as_integer();
  u.standing = found->at("standing").as_integer();
  u.slides_first_share = found->at("slides_first_share").as_real();
  for (const auto& [name, value] : found->at("scalars").as_object())
    u.scalars.push_back({name, quantiles_from_json(value)});
  for (std::size_t i = 0; i < kLevels.size(); ++i)
    u.a_qs_g_by_azimuth[i] = real_list(found->at("a_qs_g_by_azimuth").at(kLevels[i]));
  u.rose = real_list(found->at("rose"));
  u.variance_shares = named_values_from_json(found->at("variance_shares"));
  u.variance_shares_bearing = named_values_from_json(found->at("variance_shares_bearing"));
  u.inputs = named_values_from_json(found->at("inputs"));
  u.draws_file = found->at("draws_file").as_string();
  return u;
}

}  // namespace

Json to_json(const survey::Quantiles& q) {
  return Json::object({{"p05", real_or_never(q.p05, "p05")},
                       {"p16", real_or_never(q.p16, "p16")},
                       {"p50", real_or_never(q.p50, "p50")},
                       {"p84", real_or_never(q.p84, "p84")},
                       {"p95", real_or_never(q.p95, "p95")}});
}

Json named_values_to_json(const std::vector<survey::NamedValue>& values) {
  Json out = Json::object();
  for (const auto& v : values) out.set(v.name, finite(v.value, v.name));
  return out;
}

std::vector<survey::NamedValue> named_values_from_json(const Json& json) {
  std::vector<survey::NamedValue> out;
  for (const auto& [name, value] : json.as_object()) out.push_back({name, value.as_real()});
  return out;
}

Json to_json(const survey::Tipping& t) {
  const auto point = [](const geometry::Vec3& p) { return vec3_to_json(p, "contact_m"); };
  return Json::object({{"grade", survey::name_of(t.grade)},
                       {"reasons", Json(t.reasons)},
                       {"contact_m", list_of(t.contact, point)},
                       {"contact_assumed", t.contact_assumed},
                       {"critical", maybe_edge(t.critical)},
                       {"a_qs_g_by_azimuth", finite_list(t.a_qs_g_by_azimuth, "a_qs_g_by_azimuth")},
                       {"contact_observed_share", finite(t.contact_observed_share, "contact_observed_share")},
                       {"contact_pads", t.contact_pads},
                       {"contact_slope_rad", finite(t.contact_slope_rad, "contact_slope_rad")},
                       {"contact_aspect_deg", finite(t.contact_aspect_deg, "contact_aspect_deg")},
                       {"edges", list_of(t.edges, edge_to_json)},
                       {"alpha_point_rad", finite(t.alpha_point_rad, "alpha_point_rad")},
                       {"a_qs_min_g", finite(t.a_qs_min_g, "a_qs_min_g")},
                       {"a_qs_min_toward_deg", finite(t.a_qs_min_azimuth_deg, "a_qs_min_toward_deg")},
                       {"inner", bound_to_json(t.inner)},
                       {"outer", bound_to_json(t.outer)},
                       {"friction", finite(t.friction, "friction")},
                       {"slides_first", t.slides_first},
                       {"without_pad", list_of(t.without_pad, variant_to_json)},
                       {"gaps", list_of(t.gaps, variant_to_json)},
                       {"photo_views", list_of(t.photo_views, view_to_json)},
                       {"rolling", rolling_to_json(t.rolling)},
                       {"uncertainty", uncertainty_to_json(t.uncertainty)}});
}

survey::Tipping tipping_from_json(const Json& json) {
  survey::Tipping t;
  const std::string& grade = json.at("grade").as_string();
  const auto known = survey::grade_from(grade);
  if (!known)
    throw Error(ErrorCode::invalid_input, "unknown grade")
        .found("'" + grade + "'")
        .allowed("measured, bounded, screening, not_measurable");
  t.grade = *known;
  t.reasons = text_list(json.at("reasons"));
  for (const auto& p : json.at("contact_m").as_array()) t.contact.push_back(p.as_vec3());
  t.contact_assumed = json.at("contact_assumed").as_bool();
  t.critical = maybe_edge(json, "critical");
  t.a_qs_g_by_azimuth = real_list(json.at("a_qs_g_by_azimuth"));
  t.contact_observed_share = real_or(json, "contact_observed_share", 0.0);
  if (const Json* pads = member(json, "contact_pads")) t.contact_pads = pads->as_integer();
  t.contact_slope_rad = real_or(json, "contact_slope_rad", 0.0);
  t.contact_aspect_deg = real_or(json, "contact_aspect_deg", 0.0);
  t.edges = items_of<survey::TippingEdge>(json, "edges", edge_from_json);
  t.alpha_point_rad = real_or(json, "alpha_point_rad", 0.0);
  t.a_qs_min_g = real_or(json, "a_qs_min_g", 0.0);
  t.a_qs_min_azimuth_deg = real_or(json, "a_qs_min_toward_deg", 0.0);
  t.inner = bound_from_json(json, "inner");
  t.outer = bound_from_json(json, "outer");
  t.friction = real_or(json, "friction", 0.0);
  if (const Json* slides = member(json, "slides_first")) t.slides_first = slides->as_bool();
  t.without_pad = items_of<survey::TippingVariant>(json, "without_pad", variant_from_json);
  t.gaps = items_of<survey::TippingVariant>(json, "gaps", variant_from_json);
  t.photo_views = items_of<survey::PhotoView>(json, "photo_views", view_from_json);
  t.rolling = rolling_from_json(json);
  t.uncertainty = uncertainty_from_json(json);
  return t;
}

}  // namespace cairn::io
