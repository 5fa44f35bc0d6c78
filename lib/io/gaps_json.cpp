#include "io/gaps_json.hpp"

#include <utility>

#include "io/records_json.hpp"

namespace cairn::io {
namespace {

Json rings_to_json(const std::vector<geometry::Ring>& rings) {
  Json::Array out;
  for (const auto& ring : rings) {
    Json::Array points;
    for (const auto& p : ring) points.emplace_back(Json::Array{finite(p.x(), "rings_m"), finite(p.y(), "rings_m")});
    out.emplace_back(std::move(points));
  }
  return Json(std::move(out));
}

geometry::Ring ring_from(const Json& json) {
  geometry::Ring ring;
  for (const auto& point : json.as_array()) {
    const auto p = real_list(point);
    if (p.size() != 2)
      throw base::Error(base::ErrorCode::invalid_input, "a vertex of the wrong length").allowed("[east, north]");
    ring.emplace_back(p[0], p[1]);
  }
  if (ring.size() < 3)
    throw base::Error(base::ErrorCode::invalid_input, "a ring that encloses nothing")
        .found(std::to_string(ring.size()) + " vertices")
        .allowed("3 or more");
  return ring;
}

}  // namespace

Json to_json(const survey::CoverageGap& gap) {
  Json frames = Json::array();
  for (const auto frame : gap.nearest_frames) frames.push(frame.value);
  return Json::object({{"id", gap.id.value},
                       {"reason", gap.reason},
                       {"area_m2", finite(gap.area_m2, "area_m2")},
                       {"facets", gap.facets},
                       {"centre_m", vec3_to_json(gap.centre, "centre_m")},
                       {"rings_m", rings_to_json(gap.rings)},
                       {"nearest_frames", std::move(frames)},
                       {"view", gap.view ? Json::object({{"position_m", vec3_to_json(gap.view->position, "position_m")},
                                                         {"look_at_m", vec3_to_json(gap.view->look_at, "look_at_m")}})
                                         : Json()}});
}

survey::CoverageGap gap_from_json(const Json& json) {
  survey::CoverageGap gap;
  gap.id = survey::GapId(json.at("id").as_integer());
  gap.reason = json.at("reason").as_string();
  gap.area_m2 = json.at("area_m2").as_real();
  const std::int64_t facets = json.at("facets").as_integer();
  if (facets < 0 || !(gap.area_m2 >= 0.0))
    throw base::Error(base::ErrorCode::invalid_input, "a negative area or number of facets").allowed("0 or more");
  gap.facets = static_cast<std::size_t>(facets);
  gap.centre = json.at("centre_m").as_vec3();
  for (const auto& ring : json.at("rings_m").as_array()) gap.rings.push_back(ring_from(ring));
  if (gap.rings.empty()) throw base::Error(base::ErrorCode::invalid_input, "a gap without an outline");
  for (const auto& frame : json.at("nearest_frames").as_array()) gap.nearest_frames.emplace_back(frame.as_integer());
  if (const Json* view = json.find("view"); view != nullptr && !view->is_null())
    gap.view = survey::SuggestedView{view->at("position_m").as_vec3(), view->at("look_at_m").as_vec3()};
  return gap;
}

void write_gaps(const std::filesystem::path& path, const GapsFile& file) {
  Json list = Json::array();
  for (const auto& gap : file.gaps) list.push(to_json(gap));
  write_records(path, file.frame, "gaps", std::move(list));
}

GapsFile read_gaps(const std::filesystem::path& path) {
  GapsFile file;
  UniqueIds ids;
  file.frame = read_records(path, "gaps", "gap", [&](const Json& json) {
    file.gaps.push_back(gap_from_json(json));
    ids.add(file.gaps.back().id.value);
  });
  return file;
}

}  // namespace cairn::io
