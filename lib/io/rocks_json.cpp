#include "io/rocks_json.hpp"

#include <utility>

#include "io/records_json.hpp"
#include "io/tipping_json.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

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

Json ids_to_json(const std::vector<survey::TargetId>& ids) {
  Json out = Json::array();
  for (const auto id : ids) out.push(id.value);
  return out;
}

std::vector<survey::TargetId> ids_from_json(const Json& json, std::string_view key) {
  std::vector<survey::TargetId> ids;
  if (const Json* found = json.find(key))
    for (const auto& id : found->as_array()) ids.emplace_back(id.as_integer());
  return ids;
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
                       {"noise_m", finite(r.noise_m, "noise_m")},
                       {"cap_height_sigma_m", finite(r.cap_height_sigma_m, "cap_height_sigma_m")},
                       {"shape_ratios", named_values_to_json(r.shape_ratios)},
                       {"name", r.name},
                       {"aliases", ids_to_json(r.aliases)},
                       {"supersedes", ids_to_json(r.supersedes)},
                       {"review", r.review},
                       {"tipping", to_json(r.tipping)}});
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
  if (const Json* noise = json.find("noise_m")) r.noise_m = noise->as_real();
  if (const Json* sigma = json.find("cap_height_sigma_m")) r.cap_height_sigma_m = sigma->as_real();
  if (const Json* ratios = json.find("shape_ratios")) r.shape_ratios = named_values_from_json(*ratios);
  if (const Json* name = json.find("name")) r.name = name->as_string();
  r.aliases = ids_from_json(json, "aliases");
  r.supersedes = ids_from_json(json, "supersedes");
  if (const Json* review = json.find("review")) r.review = review->as_string();
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
