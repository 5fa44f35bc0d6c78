// Point clouds.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "base/number_text.hpp"
#include "io/cloud.hpp"
#include "pipeline/info_kinds.hpp"

namespace cairn::pipeline::info {
namespace fs = std::filesystem;
namespace {

using geometry::Box3;
using geometry::PointCloud;
using io::Json;

// A LAS file above this is described by its header.
constexpr std::uint64_t kHeaderOnlyBytes = std::uint64_t{64} << 20;
// Cells of the spacing estimate hold this many points each, were they spread evenly over the box.
constexpr double kPointsPerCell = 16.0;
// Units differ from the file's own statement by less than this where they are the same unit.
constexpr double kUnitTolerance = 1e-6;

std::string_view name_of(geometry::ScalarType type) {
  constexpr std::array<std::string_view, 10> kNames = {"u8",  "i8",  "u16", "i16", "u32",
                                                       "i32", "u64", "i64", "f32", "f64"};
  return kNames[static_cast<std::size_t>(type)];
}

Box3 bounds_of(const PointCloud& cloud) {
  Box3 box;
  for (const auto& p : cloud.positions) box.extend(p);
  return box;
}

Json spacing_json(double value, std::string_view method) {
  return std::isfinite(value) && value > 0.0 ? Json::object({{"value", value}, {"method", method}}) : Json();
}

// sqrt(area / points) with the area of the horizontal cells that hold a point: an irregular outline does
// not count as empty ground.
Json occupied_spacing(const PointCloud& cloud, const Box3& box) {
  const auto n = static_cast<double>(cloud.size());
  const double width = box.size().x(), height = box.size().y();
  if (cloud.size() < 2 || !(width * height > 0.0)) return {};
  const double cell = std::sqrt(width * height / n * kPointsPerCell);
  const auto columns = static_cast<std::size_t>(width / cell) + 1, rows = static_cast<std::size_t>(height / cell) + 1;
  // Long thin boxes have more cells than points would fill; there the box itself answers.
  if (columns > 4 * cloud.size() / rows + 64) return spacing_json(std::sqrt(width * height / n), "bounding box");
  std::vector<bool> occupied(columns * rows, false);
  for (const auto& p : cloud.positions)
    occupied[std::min(rows - 1, static_cast<std::size_t>((p.y() - box.min.y()) / cell)) * columns +
             std::min(columns - 1, static_cast<std::size_t>((p.x() - box.min.x()) / cell))] = true;
  const auto cells = static_cast<double>(std::count(occupied.begin(), occupied.end(), true));
  return spacing_json(std::sqrt(std::min(cells * cell * cell, width * height) / n), "occupied cells");
}

Json range_json(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto [lo, hi] = std::minmax_element(values.begin(), values.end());
  return Json::Array{Json(*lo), Json(*hi)};
}

Json classes_json(const PointCloud& cloud) {
  std::array<std::size_t, 256> counts{};
  for (const auto c : cloud.classification) ++counts[c];
  Json json = Json::object();
  for (std::size_t c = 0; c < counts.size(); ++c)
    if (counts[c] > 0) json.set(std::to_string(c), counts[c]);
  return json;
}

// The file's own statement of its units against what its CRS says.
void compare_units(const io::SourceFacts& facts, const Json& crs, std::vector<std::string>& warnings) {
  const auto differs = [&](std::string_view member, double stated, std::string_view what) {
    const Json* unit = crs.is_object() ? crs.find(member) : nullptr;
    if (unit == nullptr || !unit->is_number() || stated == 0.0) return;
    if (std::abs(unit->as_real() - stated) > kUnitTolerance)
      warnings.push_back("the file states a " + std::string(what) + " unit of " + base::to_text(stated) +
                         " m, its coordinate reference system one of " + base::to_text(unit->as_real()) +
                         " m: nobody can tell which holds");
  };
  differs("horizontal_unit_m", facts.horizontal_unit_m, "horizontal");
  differs("vertical_unit_m", facts.vertical_unit_m, "vertical");
}

Json facts_json(const fs::path& path, const io::SourceFacts& facts, std::vector<std::string>& warnings) {
  Json json = begin(path, "cloud", facts.format);
  json.set("version", facts.version);
  json.set("points", static_cast<std::int64_t>(facts.declared_points - facts.dropped_points));
  json.set("dropped_points", static_cast<std::int64_t>(facts.dropped_points));
  Json crs = crs_json(facts.crs, warnings);
  compare_units(facts, crs, warnings);
  if (crs.is_null()) warnings.emplace_back("no coordinate reference system is declared");
  json.set("crs", std::move(crs));
  json.set("stated_horizontal_unit_m", facts.horizontal_unit_m > 0.0 ? Json(facts.horizontal_unit_m) : Json());
  json.set("stated_vertical_unit_m", facts.vertical_unit_m > 0.0 ? Json(facts.vertical_unit_m) : Json());
  return json;
}

void add_columns(Json& json, const PointCloud& cloud) {
  Json columns = Json::array();
  if (!cloud.intensity.empty()) columns.push("intensity");
  if (!cloud.classification.empty()) columns.push("classification");
  if (!cloud.colours.empty()) columns.push("colours");
  if (!cloud.normals.empty()) columns.push("normals");
  if (!cloud.gps_time.empty()) columns.push("gps_time");
  json.set("columns", std::move(columns));
  if (!cloud.classification.empty()) json.set("classes", classes_json(cloud));
  if (!cloud.gps_time.empty()) json.set("gps_time_range_s", range_json(cloud.gps_time));
}

Json las_json(const io::LasMetadata& m) {
  Json records = Json::array();
  for (const auto& r : m.records)
    records.push(Json::object({{"user_id", r.user_id},
                               {"record_id", static_cast<int>(r.record_id)},
                               {"description", r.description},
                               {"bytes", r.data.size()}}));
  Json by_return = Json::array();
  for (const auto n : m.points_by_return) by_return.push(static_cast<std::int64_t>(n));
  return Json::object({{"version", "1." + std::to_string(m.minor_version)},
                       {"point_format", m.point_format},
                       {"system_identifier", m.system_identifier},
                       {"generating_software", m.generating_software},
                       {"creation_year", static_cast<int>(m.creation_year)},
                       {"creation_day", static_cast<int>(m.creation_day)},
                       {"global_encoding", static_cast<int>(m.global_encoding)},
                       {"crs_citation", m.crs_citation},
                       {"points_by_return", std::move(by_return)},
                       {"records", std::move(records)}});
}

Json dimensions_json(const io::LasMetadata& m, const PointCloud* cloud) {
  Json list = Json::array();
  for (std::size_t d = 0; d < m.dimensions.size(); ++d) {
    const auto& dimension = m.dimensions[d];
    Json json = Json::object({{"name", dimension.name},
                              {"type", name_of(dimension.type)},
                              {"description", dimension.description},
                              {"scale", dimension.scale},
                              {"offset", dimension.offset},
                              {"no_data", dimension.no_data ? Json(*dimension.no_data) : Json()}});
    const auto* column = cloud != nullptr ? cloud->scalar(dimension.name) : nullptr;
    if (column != nullptr) json.set("range", range_json(column->values));
    list.push(std::move(json));
  }
  return list;
}

Json columns_of_format(int point_format) {
  Json columns = Json::array();
  columns.push("intensity");
  columns.push("classification");
  if (point_format == 2 || point_format == 3 || point_format == 5 || point_format == 7 || point_format == 8 ||
      point_format == 10)
    columns.push("colours");
  if (point_format != 0 && point_format != 2) columns.push("gps_time");
  return columns;
}

// How far the points leave the header's box, in steps of the scale.
void compare_bounds(const io::LasMetadata& m, const Box3& box, std::vector<std::string>& warnings) {
  if (box.empty()) return;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = std::abs(m.scale[axis]);
    if (box.min[axis] < m.bounds.min[axis] - step || box.max[axis] > m.bounds.max[axis] + step) {
      warnings.emplace_back("points lie outside the bounds that the header states");
      return;
    }
  }
}

Json from_cloud(const fs::path& path, const io::CloudData& data) {
  std::vector<std::string> warnings = data.facts.warnings;
  Json json = facts_json(path, data.facts, warnings);
  const Box3 box = bounds_of(data.cloud);
  json.set("bounds", to_json(box));
  json.set("bounds_source", "points");
  json.set("spacing", occupied_spacing(data.cloud, box));
  add_columns(json, data.cloud);
  Json list = Json::array();
  for (const auto& column : data.cloud.scalars)
    list.push(
        Json::object({{"name", column.name}, {"type", name_of(column.type)}, {"range", range_json(column.values)}}));
  json.set("dimensions", std::move(list));
  if (!data.facts.comments.empty()) json.set("comments", data.facts.comments);
  json.set("warnings", warnings);
  return json;
}

}  // namespace

Json describe_las(const fs::path& path, const InfoOptions& options) {
  const io::LasReader reader(path);
  const io::LasMetadata& m = reader.metadata();
  const bool header_only = !options.full && fs::file_size(path) > kHeaderOnlyBytes;
  std::optional<io::LasCloud> read;
  if (!header_only) read = io::read_las(path);
  const io::SourceFacts& facts = read ? read->facts : reader.facts();
  std::vector<std::string> warnings = facts.warnings;
  Json json = facts_json(path, facts, warnings);
  Box3 box = m.bounds;
  if (read) {
    box = bounds_of(read->cloud);
    compare_bounds(m, box, warnings);
  }
  if (m.point_count == 0) box = Box3();
  json.set("bounds", to_json(box));
  json.set("bounds_source", read ? "points" : "header");
  json.set("scale", Json(m.scale));
  json.set("offset", Json(m.offset));
  if (read) {
    json.set("spacing", occupied_spacing(read->cloud, box));
    add_columns(json, read->cloud);
  } else {
    const auto n = static_cast<double>(m.point_count);
    json.set("spacing",
             box.empty() ? Json() : spacing_json(std::sqrt(box.size().x() * box.size().y() / n), "header box"));
    json.set("columns", columns_of_format(m.point_format));
  }
  json.set("dimensions", dimensions_json(m, read ? &read->cloud : nullptr));
  json.set("las", las_json(m));
  json.set("warnings", warnings);
  return json;
}

Json describe_cloud(const fs::path& path, const InfoOptions& /*options*/) {
  return from_cloud(path, io::read_cloud(path));
}

}  // namespace cairn::pipeline::info
