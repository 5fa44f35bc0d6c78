// What targets.json, rocks.json and obstacles.json have in common.
#pragma once

#include <cmath>
#include <filesystem>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "geometry/vec.hpp"
#include "io/json.hpp"
#include "io/survey_json.hpp"

namespace cairn::io {

inline constexpr int kRecordsSchemaVersion = 1;

// Square matrix of 2 or 3 rows as a list of rows, and back; throws invalid_input for another shape.
template <int N>
[[nodiscard]] Json matrix_to_json(const Eigen::Matrix<double, N, N>& m) {
  Json::Array out;
  for (int r = 0; r < N; ++r) {
    Json::Array row;
    for (int c = 0; c < N; ++c) row.emplace_back(m(r, c));
    out.emplace_back(std::move(row));
  }
  return Json(std::move(out));
}

template <int N>
[[nodiscard]] Eigen::Matrix<double, N, N> matrix_from_json(const Json& json) {
  const auto refuse = [](std::size_t found) {
    throw base::Error(base::ErrorCode::invalid_input, "matrix of the wrong size")
        .found(std::to_string(found))
        .allowed(std::to_string(N) + " rows of " + std::to_string(N));
  };
  Eigen::Matrix<double, N, N> m;
  const auto& rows = json.as_array();
  if (rows.size() != static_cast<std::size_t>(N)) refuse(rows.size());
  for (int r = 0; r < N; ++r) {
    const auto& row = rows[static_cast<std::size_t>(r)].as_array();
    if (row.size() != static_cast<std::size_t>(N)) refuse(row.size());
    for (int c = 0; c < N; ++c) m(r, c) = row[static_cast<std::size_t>(c)].as_real();
  }
  return m;
}

// Json writes a number that is not finite as null; a result must not lose one silently.
inline double finite(double value, std::string_view name) {
  if (!std::isfinite(value))
    throw base::Error(base::ErrorCode::invalid_input, "number is not finite").found(std::string(name));
  return value;
}
[[nodiscard]] Json finite_list(const std::vector<double>& values, std::string_view name);
[[nodiscard]] std::vector<double> real_list(const Json& json);
[[nodiscard]] std::vector<std::string> text_list(const Json& json);
[[nodiscard]] Json vec3_to_json(const geometry::Vec3& v, std::string_view name);

// {"schema_version", "frame": {...}, "<list>": [...]}.
void write_records(const std::filesystem::path& path, const survey::Origin& frame, std::string_view list, Json records);

// Calls `take(record)` for each member of the list; errors gain file and "<one> N of the list".
template <typename Take>
[[nodiscard]] survey::Origin read_records(const std::filesystem::path& path, std::string_view list,
                                          std::string_view one, Take&& take) {
  const Json json = read_json(path);
  std::string where = "file";
  try {
    if (const auto version = json.at("schema_version").as_integer(); version != kRecordsSchemaVersion)
      throw base::Error(base::ErrorCode::invalid_input, "unknown schema version")
          .found(std::to_string(version))
          .allowed(std::to_string(kRecordsSchemaVersion));
    where = "frame";
    const survey::Origin frame = origin_from_json(json.at("frame"));
    std::size_t index = 0;
    where = std::string(list);
    for (const auto& record : json.at(list).as_array()) {
      where = std::string(one) + " " + std::to_string(++index) + " of the list";
      take(record);
    }
    return frame;
  } catch (base::Error& error) {
    error.default_file(path.string());
    error.in(where);
    throw;
  }
}

// Throws invalid_input where the id is negative or was seen before.
class UniqueIds {
 public:
  void add(std::int64_t id);

 private:
  std::set<std::int64_t> seen_;
};

}  // namespace cairn::io
