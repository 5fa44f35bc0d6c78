#include "io/rocks_json.hpp"

#include <utility>

#include "io/records_json.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

Json edge_to_json(const survey::TippingEdge& e) {
  return Json::object({{"topple_toward_deg", finite(e.azimuth_deg, "topple_toward_deg")},
                       {"alpha_rad", finite(e.alpha_rad, "alpha_rad")},
                       {"r_m", finite(e.r_m, "r_m")},
                       {"p_rad_s", finite(e.p_rad_s, "p_rad_s")},
                       {"a_qs_g", finite(e.a_qs_g, "a_qs_g")},
                       {"v_min_m_s", finite(e.v_min_m_s, "v_min_m_s")}});
}

survey::TippingEdge edge_from_json(const Json& json) {
  survey::TippingEdge e;
  e.azimuth_deg = json.at("topple_toward_deg").as_real();
  e.alpha_rad = json.at("alpha_rad").as_real();
  e.r_m = json.at("r_m").as_real();
  e.p_rad_s = json.at("p_rad_s").as_real();
  e.a_qs_g = json.at("a_qs_g").as_real();
  e.v_min_m_s = json.at("v_min_m_s").as_real();
  return e;
}

Json tipping_to_json(const survey::Tipping& t) {
  Json contact = Json::array();
  for (const auto& p : t.contact) contact.push(vec3_to_json(p, "contact_m"));
  return Json::object({{"grade", survey::name_of(t.grade)},
                       {"reasons", Json(t.reasons)},
                       {"contact_m", std::move(contact)},
                       {"contact_assumed", t.contact_assumed},
                       {"critical", t.critical ? edge_to_json(*t.critical) : Json()},
                       {"a_qs_g_by_azimuth", finite_list(t.a_qs_g_by_azimuth, "a_qs_g_by_azimuth")}});
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
  if (const Json* edge = json.find("critical"); edge != nullptr && !edge->is_null()) t.critical = edge_from_json(*edge);
  t.a_qs_g_by_azimuth = real_list(json.at("a_qs_g_by_azimuth"));
  return t;
}

Json mass_to_json(const geometry::MassProperties& m) {
  for (int i = 0; i < 9; ++i) finite(m.inertia_per_density.data()[i], "inertia_per_density_m5");
  return Json::object({{"volume_m3", finite(m.volume, "volume_m3")},
                       {"area_m2", finite(m.area, "area_m2")},
                       {"centre_of_mass_m", vec3_to_json(m.centre_of_mass, "centre_of_mass_m")},
                       {"inertia_per_density_m5", matrix_to_json<3>(m.inertia_per_density)}});
}

geometry::MassProperties mass_from_json(const Json& json) {
  geometry::MassProperties m;
  m.volume = json.at("volume_m3").as_real();
  m.area = json.at("area_m2").as_real();
  m.centre_of_mass = json.at("centre_of_mass_m").as_vec3();
  m.inertia_per_density = matrix_from_json<3>(json.at("inertia_per_density_m5"));
  return m;
}

survey::CapModel cap_of(const std::string& name) {
  for (const auto cap :
       {survey::CapModel::none, survey::CapModel::plane, survey::CapModel::patch, survey::CapModel::wrap})
    if (survey::name_of(cap) == name) return cap;
  throw Error(ErrorCode::invalid_input, "unknown cap model")
      .found("'" + name + "'")
      .allowed("none, plane, patch, wrap");
}

}  // namespace

Json to_json(const survey::Rock& r) {
  return Json::object({{"id", r.target.value},
                       {"class", r.object_class},
                       {"rejected", r.rejected},
                       {"reasons", Json(r.reasons)},
                       {"point_count", r.point_count},
                       {"point_spacing_m", finite(r.point_spacing_m, "point_spacing_m")},
                       {"size_m", vec3_to_json(r.size_m, "size_m")},
                       {"base_height_m", finite(r.base_height_m, "base_height_m")},
                       {"length_azimuth_deg", finite(r.length_azimuth_deg, "length_azimuth_deg")},
                       {"cap", survey::name_of(r.cap)},
                       {"unseen_area_fraction", finite(r.unseen_area_fraction, "unseen_area_fraction")},
                       {"mass", r.mass ? mass_to_json(*r.mass) : Json()},
                       {"hull_volume_m3", finite(r.hull_volume_m3, "hull_volume_m3")},
                       {"density_kg_m3", finite(r.density_kg_m3, "density_kg_m3")},
                       {"density_assumed", r.density_assumed},
                       {"tipping", tipping_to_json(r.tipping)}});
}

survey::Rock rock_from_json(const Json& json) {
  survey::Rock r;
  r.target = survey::TargetId(json.at("id").as_integer());
  r.object_class = json.at("class").as_string();
  r.rejected = json.at("rejected").as_bool();
  r.reasons = text_list(json.at("reasons"));
  const std::int64_t points = json.at("point_count").as_integer();
  if (points < 0)
    throw Error(ErrorCode::invalid_input, "point_count is negative").found(std::to_string(points)).allowed("0 or more");
  r.point_count = static_cast<std::size_t>(points);
  r.point_spacing_m = json.at("point_spacing_m").as_real();
  r.size_m = json.at("size_m").as_vec3();
  r.base_height_m = json.at("base_height_m").as_real();
  r.length_azimuth_deg = json.at("length_azimuth_deg").as_real();
  r.cap = cap_of(json.at("cap").as_string());
  r.unseen_area_fraction = json.at("unseen_area_fraction").as_real();
  if (const Json* mass = json.find("mass"); mass != nullptr && !mass->is_null()) r.mass = mass_from_json(*mass);
  r.hull_volume_m3 = json.at("hull_volume_m3").as_real();
  r.density_kg_m3 = json.at("density_kg_m3").as_real();
  r.density_assumed = json.at("density_assumed").as_bool();
  r.tipping = tipping_from_json(json.at("tipping"));
  return r;
}

void write_rocks(const std::filesystem::path& path, const RocksFile& file) {
  Json list = Json::array();
  for (const auto& rock : file.rocks) list.push(to_json(rock));
  write_records(path, file.frame, "rocks", std::move(list));
}

RocksFile read_rocks(const std::filesystem::path& path) {
  RocksFile file;
  UniqueIds ids;
  file.frame = read_records(path, "rocks", "rock", [&](const Json& json) {
    file.rocks.push_back(rock_from_json(json));
    ids.add(file.rocks.back().target.value);
  });
  return file;
}

}  // namespace cairn::io
