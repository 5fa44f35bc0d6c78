#include "io/truth.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/csv.hpp"
#include "io/ply.hpp"
#include "io/records_json.hpp"
#include "io/survey_folder.hpp"
#include "io/survey_json.hpp"

namespace cairn::io {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec3;

constexpr int kTruthSchemaVersion = 1;
constexpr std::int64_t kMaxId = INT64_MAX;

Json rings_to_json(const std::vector<std::vector<Vec3>>& rings, std::string_view name) {
  Json out = Json::array();
  for (const auto& ring : rings) {
    Json points = Json::array();
    for (const Vec3& p : ring) points.push(vec3_to_json(p, name));
    out.push(std::move(points));
  }
  return out;
}

std::vector<std::vector<Vec3>> rings_from_json(const Json& json) {
  std::vector<std::vector<Vec3>> rings;
  for (const auto& ring : json.as_array()) {
    rings.emplace_back();
    for (const auto& p : ring.as_array()) rings.back().push_back(p.as_vec3());
  }
  return rings;
}

Json object_to_json(const survey::TruthObject& object) {
  const auto& c = object.cylinder;
  Json json = Json::object(
      {{"id", object.id.value},
       {"class", object.object_class},
       {"sought", object.sought},
       {"cylinder",
        Json::object({{"axis_m", Json::Array{Json(finite(c.axis.x(), "axis")), Json(finite(c.axis.y(), "axis"))}},
                      {"bottom_m", finite(c.bottom, "bottom")},
                      {"top_m", finite(c.top, "top")},
                      {"radius_m", finite(c.radius, "radius")}})},
       {"mesh", object.mesh},
       {"volume_m3", finite(object.volume_m3, "volume")},
       {"centre_of_mass_m", vec3_to_json(object.centre_of_mass, "centre of mass")}});
  json.set("contact_rim_m", rings_to_json(object.contact_rim, "contact rim"));
  json.set("contact_bearing_m", rings_to_json(object.contact_bearing, "bearing contact"));
  return json;
}

survey::TruthObject object_from_json(const Json& json) {
  survey::TruthObject object;
  object.id = survey::ObjectId(json.at("id").as_integer());
  if (!object.id.valid())
    throw Error(ErrorCode::invalid_input, "object id is negative").found(std::to_string(object.id.value));
  object.object_class = json.at("class").as_string();
  object.sought = json.at("sought").as_bool();
  const Json& c = json.at("cylinder");
  const auto& axis = c.at("axis_m").as_array();
  if (axis.size() != 2)
    throw Error(ErrorCode::invalid_input, "the axis of a cylinder is no point")
        .found(std::to_string(axis.size()) + " numbers")
        .allowed("[east, north]");
  object.cylinder = {{axis[0].as_real(), axis[1].as_real()},
                     c.at("bottom_m").as_real(),
                     c.at("top_m").as_real(),
                     c.at("radius_m").as_real()};
  if (object.cylinder.top < object.cylinder.bottom || object.cylinder.radius < 0.0)
    throw Error(ErrorCode::invalid_input, "a cylinder of no size")
        .found("bottom " + base::to_text(object.cylinder.bottom) + ", top " + base::to_text(object.cylinder.top) +
               ", radius " + base::to_text(object.cylinder.radius))
        .allowed("bottom <= top, radius >= 0");
  object.mesh = json.at("mesh").as_string();
  object.volume_m3 = json.at("volume_m3").as_real();
  object.centre_of_mass = json.at("centre_of_mass_m").as_vec3();
  object.contact_rim = rings_from_json(json.at("contact_rim_m"));
  object.contact_bearing = rings_from_json(json.at("contact_bearing_m"));
  return object;
}

template <typename Record, typename Id>
bool has(const std::vector<Record>& records, Id id) {
  const auto it =
      std::lower_bound(records.begin(), records.end(), id, [](const Record& r, Id wanted) { return r.id < wanted; });
  return it != records.end() && it->id == id;
}

void write_boxes(const fs::path& path, const std::vector<survey::TruthBox>& boxes) {
  CsvWriter table(path,
                  {"frame_id", "object_id", "xmin_px", "ymin_px", "xmax_px", "ymax_px", "whole", "visible_share"});
  for (const auto& b : boxes) {
    for (const double value : {b.box.xmin, b.box.ymin, b.box.xmax, b.box.ymax, b.visible_share})
      static_cast<void>(finite(value, "true box"));
    table.cell(b.frame.value).cell(b.object.value).cell(b.box.xmin).cell(b.box.ymin).cell(b.box.xmax);
    table.cell(b.box.ymax).cell(b.whole ? 1 : 0).cell(b.visible_share).end_row();
  }
  table.finish();
}

void read_boxes(const fs::path& path, survey::Truth& truth) {
  CsvReader table(path);
  const auto frame = table.column("frame_id"), object = table.column("object_id"), xmin = table.column("xmin_px"),
             ymin = table.column("ymin_px"), xmax = table.column("xmax_px"), ymax = table.column("ymax_px"),
             whole = table.column("whole"), share = table.column("visible_share");
  while (table.next()) {
    survey::TruthBox b;
    b.frame = survey::FrameId(table.integer(frame, 0, kMaxId));
    if (!has(truth.frames, b.frame)) throw table.error(frame, "true box of an unknown frame");
    b.object = survey::ObjectId(table.integer(object, 0, kMaxId));
    if (!has(truth.objects, b.object)) throw table.error(object, "true box of an unknown object");
    b.box = {table.real(xmin), table.real(ymin), table.real(xmax), table.real(ymax)};
    if (b.box.xmax < b.box.xmin) throw table.error(xmax, "box ends before it begins").allowed("xmin_px or more");
    if (b.box.ymax < b.box.ymin) throw table.error(ymax, "box ends before it begins").allowed("ymin_px or more");
    b.whole = table.integer(whole, 0, 1) == 1;
    b.visible_share = table.real(share);
    if (!(b.visible_share >= 0.0 && b.visible_share <= 1.0))
      throw table.error(share, "share out of range").allowed("0 to 1");
    truth.boxes.push_back(b);
  }
  std::stable_sort(truth.boxes.begin(), truth.boxes.end(), [](const auto& a, const auto& b) {
    return std::pair(a.frame, a.object) < std::pair(b.frame, b.object);
  });
}

void write_origins(const fs::path& path, const std::vector<survey::DetectionOrigin>& origins) {
  CsvWriter table(path, {"detection_id", "object_id", "clutter"});
  for (const auto& o : origins) {
    table.cell(o.detection.value);
    if (o.object.valid()) table.cell(o.object.value);
    else table.cell("");
    if (o.clutter >= 0) table.cell(o.clutter);
    else table.cell("");
    table.end_row();
  }
  table.finish();
}

void read_origins(const fs::path& path, survey::Truth& truth) {
  CsvReader table(path);
  const auto id = table.column("detection_id"), object = table.column("object_id"), clutter = table.column("clutter");
  std::set<std::int64_t> ids;
  while (table.next()) {
    survey::DetectionOrigin o;
    o.detection = survey::DetectionId(table.integer(id, 0, kMaxId));
    if (!ids.insert(o.detection.value).second) throw table.error(id, "id appears twice");
    if (!table.text(object).empty()) o.object = survey::ObjectId(table.integer(object, 0, kMaxId));
    if (o.object.valid() && !has(truth.objects, o.object)) throw table.error(object, "detection of an unknown object");
    if (!table.text(clutter).empty()) o.clutter = table.integer(clutter, 0, kMaxId);
    truth.detections.push_back(o);
  }
  std::stable_sort(truth.detections.begin(), truth.detections.end(),
                   [](const auto& a, const auto& b) { return a.detection < b.detection; });
}

}  // namespace

std::string truth_mesh_name(survey::ObjectId id) {
  return "truth/meshes/" + std::to_string(id.value) + ".ply";
}

void write_truth_mesh(const fs::path& folder, survey::ObjectId id, const geometry::TriangleMesh& mesh) {
  fs::create_directories(folder / "truth" / "meshes");
  write_ply(folder / truth_mesh_name(id), mesh);
}

void write_truth(const survey::Truth& truth, const survey::Origin& frame, const fs::path& folder) {
  fs::create_directories(folder / "truth");
  Json objects = Json::array();
  for (const auto& object : truth.objects) objects.push(object_to_json(object));
  const Json json = Json::object({{"schema_version", kTruthSchemaVersion},
                                  {"scene", truth.scene},
                                  {"seed", static_cast<std::int64_t>(truth.seed)},
                                  {"frame", to_json(frame)},
                                  {"objects", std::move(objects)}});
  base::write_file(folder / "truth.json", json.dump() + "\n");
  write_frames(folder / "truth" / "frames.csv", truth.frames);
  write_boxes(folder / "truth" / "boxes.csv", truth.boxes);
  write_origins(folder / "truth" / "detections.csv", truth.detections);
}

survey::Truth read_truth(const fs::path& path) {
  const Json json = read_json(path);
  survey::Truth truth;
  std::string where = "file";
  try {
    if (const auto version = json.at("schema_version").as_integer(); version != kTruthSchemaVersion)
      throw Error(ErrorCode::invalid_input, "unknown schema version")
          .found(std::to_string(version))
          .allowed(std::to_string(kTruthSchemaVersion));
    truth.scene = json.at("scene").as_string();
    truth.seed = static_cast<std::uint64_t>(json.at("seed").as_integer());
    for (const auto& item : json.at("objects").as_array()) {
      where = "object " + std::to_string(truth.objects.size() + 1) + " of the list";
      truth.objects.push_back(object_from_json(item));
    }
    where = "objects";
    std::stable_sort(truth.objects.begin(), truth.objects.end(),
                     [](const auto& a, const auto& b) { return a.id < b.id; });
    for (std::size_t i = 1; i < truth.objects.size(); ++i)
      if (truth.objects[i].id == truth.objects[i - 1].id)
        throw Error(ErrorCode::invalid_input, "object id appears twice")
            .found(std::to_string(truth.objects[i].id.value));
  } catch (Error& error) {
    error.default_file(path.string());
    error.in(where);
    throw;
  }
  const fs::path folder = path.parent_path() / "truth";
  truth.frames = read_frames(folder / "frames.csv");
  read_boxes(folder / "boxes.csv", truth);
  read_origins(folder / "detections.csv", truth);
  return truth;
}

}  // namespace cairn::io
