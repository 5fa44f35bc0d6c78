#include "io/records_json.hpp"

namespace cairn::io {

Json finite_list(const std::vector<double>& values, std::string_view name) {
  Json::Array out;
  out.reserve(values.size());
  for (const double value : values) out.emplace_back(finite(value, name));
  return Json(std::move(out));
}

std::vector<double> real_list(const Json& json) {
  std::vector<double> out;
  for (const auto& value : json.as_array()) out.push_back(value.as_real());
  return out;
}

std::vector<std::string> text_list(const Json& json) {
  std::vector<std::string> out;
  for (const auto& value : json.as_array()) out.push_back(value.as_string());
  return out;
}

Json vec3_to_json(const geometry::Vec3& v, std::string_view name) {
  for (int i = 0; i < 3; ++i) finite(v[i], name);
  return Json(v);
}

void write_records(const std::filesystem::path& path, const survey::Origin& frame, std::string_view list,
                   Json records) {
  const Json json = Json::object(
      {{"schema_version", kRecordsSchemaVersion}, {"frame", to_json(frame)}, {std::string(list), std::move(records)}});
  base::write_file(path, json.dump() + "\n");
}

void UniqueIds::add(std::int64_t id) {
  if (id < 0)
    throw base::Error(base::ErrorCode::invalid_input, "id is negative").found(std::to_string(id)).allowed("0 or more");
  if (!seen_.insert(id).second)
    throw base::Error(base::ErrorCode::invalid_input, "id appears twice").found(std::to_string(id));
}

}  // namespace cairn::io
