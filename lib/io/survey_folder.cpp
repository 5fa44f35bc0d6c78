#include "io/survey_folder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/csv.hpp"
#include "io/survey_json.hpp"

namespace cairn::io {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Mat3;
using geometry::Quaternion;

constexpr double kQuaternionTolerance = 1e-3;  // of |q|: formats.md's bar for every imported pose
constexpr std::int64_t kMaxId = INT64_MAX;

constexpr std::array<std::string_view, 14> kFrameColumns{"frame_id", "time_ns",    "camera_id", "image",        "x_m",
                                                         "y_m",      "z_m",        "qw",        "qx",           "qy",
                                                         "qz",       "sigma_xy_m", "sigma_z_m", "sigma_rot_deg"};
constexpr std::array<std::string_view, 8> kDetectionColumns{"detection_id", "frame_id", "class",   "score",
                                                            "xmin_px",      "ymin_px",  "xmax_px", "ymax_px"};

// Steps of one unit in the last place.
double nudged(double value, int steps) {
  for (; steps > 0; --steps) value = std::nextafter(value, HUGE_VAL);
  for (; steps < 0; ++steps) value = std::nextafter(value, -HUGE_VAL);
  return value;
}

// Calls take(q') for q and its neighbours within two units in the last place of each component, nearest
// first, until one is taken.
template <typename Take>
std::optional<Quaternion> first_near(const Quaternion& q, Take&& take) {
  for (int reach = 0; reach <= 2; ++reach)
    for (int w = -reach; w <= reach; ++w)
      for (int x = -reach; x <= reach; ++x)
        for (int y = -reach; y <= reach; ++y)
          for (int z = -reach; z <= reach; ++z) {
            if (std::max({std::abs(w), std::abs(x), std::abs(y), std::abs(z)}) != reach) continue;
            const Quaternion near{nudged(q.qw, w), nudged(q.qx, x), nudged(q.qy, y), nudged(q.qz, z)};
            if (take(near)) return near;
          }
  return std::nullopt;
}

// Quaternion whose rotation_matrix is `rotation` bit for bit. The obvious one often misses by a unit in
// the last place of one element; mostly one of its neighbours then does it.
std::optional<Quaternion> exact_quaternion(const Mat3& rotation) {
  return first_near(geometry::quaternion(rotation),
                    [&](const Quaternion& q) { return geometry::rotation_matrix(q) == rotation; });
}

// The rotation itself where it has an exact quaternion, else a neighbour that has one.
Mat3 exact_rotation(const Mat3& rotation) {
  if (exact_quaternion(rotation)) return rotation;
  const auto near = first_near(geometry::quaternion(rotation), [](const Quaternion& q) {
    return exact_quaternion(geometry::rotation_matrix(q)).has_value();
  });
  return near ? geometry::rotation_matrix(*near) : rotation;
}

template <typename Record>
void sort_by_id(std::vector<Record>& records) {
  std::stable_sort(records.begin(), records.end(), [](const Record& a, const Record& b) { return a.id < b.id; });
}

template <typename Id>
class Lines {
 public:
  // Throws where the id was there before.
  void add(Id id, const CsvReader& table, std::size_t column) {
    const auto [it, fresh] = lines_.emplace(id.value, table.line());
    if (!fresh)
      throw table.error(column, "id appears twice").hint("It stands on line " + std::to_string(it->second) + " too");
  }
  [[nodiscard]] bool has(Id id) const { return lines_.contains(id.value); }
  [[nodiscard]] std::size_t size() const { return lines_.size(); }

 private:
  std::unordered_map<std::int64_t, std::uint64_t> lines_;
};

using FrameLines = Lines<survey::FrameId>;

double not_negative(const CsvReader& table, std::size_t column) {
  const auto value = table.optional_real(column);
  if (value && *value < 0.0)
    throw table.error(column, "standard deviation is negative").allowed("0 or more; empty = not known");
  return value.value_or(0.0);
}

// `survey` names the cameras there are; without it any camera id is taken.
std::vector<survey::Frame> frames_of(const fs::path& path, const survey::Survey* survey, FrameLines& lines) {
  std::vector<survey::Frame> frames;
  CsvReader table(path);
  const auto id = table.column("frame_id"), time = table.column("time_ns"), camera = table.column("camera_id"),
             image = table.column("image"), x = table.column("x_m"), y = table.column("y_m"), z = table.column("z_m"),
             qw = table.column("qw"), qx = table.column("qx"), qy = table.column("qy"), qz = table.column("qz"),
             sigma_xy = table.column("sigma_xy_m"), sigma_z = table.column("sigma_z_m"),
             sigma_rot = table.column("sigma_rot_deg");
  while (table.next()) {
    survey::Frame frame;
    frame.id = survey::FrameId(table.integer(id, 0, kMaxId));
    lines.add(frame.id, table, id);
    frame.time_ns = base::trim(table.text(time)).empty() ? 0 : table.integer(time);
    frame.camera = survey::CameraId(table.integer(camera, 0, kMaxId));
    if (survey != nullptr && survey->camera(frame.camera) == nullptr)
      throw table.error(camera, "frame of an unknown camera").allowed("a camera id of survey.json");
    frame.image = table.text(image);
    frame.T_world_camera.translation = {table.real(x), table.real(y), table.real(z)};
    const Quaternion q{table.real(qw), table.real(qx), table.real(qy), table.real(qz)};
    if (!(std::abs(q.norm() - 1.0) <= kQuaternionTolerance))
      throw table.error("quaternion is not of unit length")
          .found("|q| = " + base::to_text(q.norm()))
          .allowed("1 within " + base::to_text(kQuaternionTolerance))
          .hint("Check the order of the columns qw, qx, qy, qz");
    frame.T_world_camera.rotation = exact_rotation(geometry::rotation_matrix(q));
    frame.sigma_xy_m = not_negative(table, sigma_xy);
    frame.sigma_z_m = not_negative(table, sigma_z);
    frame.sigma_rot_deg = not_negative(table, sigma_rot);
    frames.push_back(std::move(frame));
  }
  sort_by_id(frames);
  return frames;
}

void require_frame(const CsvReader& table, std::size_t column, survey::FrameId frame, const FrameLines& frames,
                   std::string_view what) {
  if (!frames.has(frame))
    throw table.error(column, std::string(what) + " of an unknown frame")
        .allowed("one of the " + std::to_string(frames.size()) + " frame ids of frames.csv")
        .hint("Remove the row, or add the frame with its pose");
}

void read_detections(const fs::path& path, survey::Survey& survey, const FrameLines& frames) {
  CsvReader table(path);
  const auto id = table.column("detection_id"), frame = table.column("frame_id"), name = table.column("class"),
             score = table.column("score"), xmin = table.column("xmin_px"), ymin = table.column("ymin_px"),
             xmax = table.column("xmax_px"), ymax = table.column("ymax_px");
  Lines<survey::DetectionId> lines;
  while (table.next()) {
    survey::Detection d;
    d.id = survey::DetectionId(table.integer(id, 0, kMaxId));
    lines.add(d.id, table, id);
    d.frame = survey::FrameId(table.integer(frame, 0, kMaxId));
    require_frame(table, frame, d.frame, frames, "detection");
    d.object_class = table.required(name);
    d.score = table.real(score);
    if (d.score < 0.0 || d.score > 1.0) throw table.error(score, "score out of range").allowed("0 to 1");
    d.box = {table.real(xmin), table.real(ymin), table.real(xmax), table.real(ymax)};
    if (d.box.xmax < d.box.xmin) throw table.error(xmax, "box ends before it begins").allowed("xmin_px or more");
    if (d.box.ymax < d.box.ymin) throw table.error(ymax, "box ends before it begins").allowed("ymin_px or more");
    survey.detections.push_back(std::move(d));
  }
  sort_by_id(survey.detections);
}

void read_ties(const fs::path& points, const fs::path& observations, survey::Survey& survey, const FrameLines& frames) {
  Lines<survey::TiePointId> lines;
  {
    CsvReader table(points);
    const auto id = table.column("tie_id"), x = table.column("x_m"), y = table.column("y_m"), z = table.column("z_m");
    while (table.next()) {
      survey::TiePoint tie;
      tie.id = survey::TiePointId(table.integer(id, 0, kMaxId));
      lines.add(tie.id, table, id);
      tie.p_world = {table.real(x), table.real(y), table.real(z)};
      survey.ties.push_back(std::move(tie));
    }
  }
  sort_by_id(survey.ties);
  CsvReader table(observations);
  const auto id = table.column("tie_id"), frame = table.column("frame_id"), u = table.column("u_px"),
             v = table.column("v_px");
  while (table.next()) {
    const survey::TiePointId tie(table.integer(id, 0, kMaxId));
    const auto it =
        std::lower_bound(survey.ties.begin(), survey.ties.end(), tie,
                         [](const survey::TiePoint& p, survey::TiePointId wanted) { return p.id < wanted; });
    if (it == survey.ties.end() || it->id != tie)
      throw table.error(id, "observation of an unknown tie point").allowed("a tie_id of tie_points.csv");
    const survey::FrameId seen_in(table.integer(frame, 0, kMaxId));
    require_frame(table, frame, seen_in, frames, "observation");
    it->observations.push_back({seen_in, {table.real(u), table.real(v)}});
  }
}

void require_finite(std::initializer_list<double> values, const std::string& record) {
  for (const double value : values)
    if (!std::isfinite(value))
      throw Error(ErrorCode::invalid_input, "number is not finite").record(record).found(base::to_text(value));
}

std::string text_of(std::int64_t id) {
  return std::to_string(id);
}

void write_frame_table(const fs::path& path, const std::vector<survey::Frame>& frames) {
  CsvWriter table(path, kFrameColumns);
  for (const auto& frame : frames) {
    const auto& p = frame.T_world_camera.translation;
    const Mat3& rotation = frame.T_world_camera.rotation;
    const Quaternion q = exact_quaternion(rotation).value_or(geometry::quaternion(rotation));
    require_finite(
        {p.x(), p.y(), p.z(), q.qw, q.qx, q.qy, q.qz, frame.sigma_xy_m, frame.sigma_z_m, frame.sigma_rot_deg},
        "frame " + text_of(frame.id.value));
    table.cell(frame.id.value).cell(frame.time_ns).cell(frame.camera.value).cell(frame.image);
    table.cell(p.x()).cell(p.y()).cell(p.z()).cell(q.qw).cell(q.qx).cell(q.qy).cell(q.qz);
    table.cell(frame.sigma_xy_m).cell(frame.sigma_z_m).cell(frame.sigma_rot_deg);
    table.end_row();
  }
  table.finish();
}

void write_ties(const fs::path& folder, const std::vector<survey::TiePoint>& ties) {
  CsvWriter points(folder / "tie_points.csv", {"tie_id", "x_m", "y_m", "z_m"});
  CsvWriter observations(folder / "tie_observations.csv", {"tie_id", "frame_id", "u_px", "v_px"});
  for (const auto& tie : ties) {
    const std::string record = "tie point " + text_of(tie.id.value);
    require_finite({tie.p_world.x(), tie.p_world.y(), tie.p_world.z()}, record);
    points.cell(tie.id.value).cell(tie.p_world.x()).cell(tie.p_world.y()).cell(tie.p_world.z()).end_row();
    for (const auto& seen : tie.observations) {
      require_finite({seen.pixel.x(), seen.pixel.y()}, record);
      observations.cell(tie.id.value).cell(seen.frame.value).cell(seen.pixel.x()).cell(seen.pixel.y()).end_row();
    }
  }
  points.finish();
  observations.finish();
}

bool starts_with(const fs::path& path, const fs::path& folder) {
  const auto [end, ignored] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end == folder.end();
}

fs::path normal(const fs::path& path) {
  fs::path result = fs::weakly_canonical(fs::absolute(path));
  return result.filename().empty() ? result.parent_path() : result;
}

}  // namespace

survey::Survey read_survey(const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code))
    throw Error(ErrorCode::not_found, "no such survey folder").file(folder.string()).hint("Make one with cairn import");
  survey::Survey survey;
  const fs::path manifest = folder / "survey.json";
  survey.manifest = manifest_from_json(read_json(manifest), manifest.string());
  FrameLines frames;
  survey.frames = frames_of(folder / "frames.csv", &survey, frames);
  if (fs::exists(folder / "detections.csv", code)) read_detections(folder / "detections.csv", survey, frames);
  if (fs::exists(folder / "tie_points.csv", code))
    read_ties(folder / "tie_points.csv", folder / "tie_observations.csv", survey, frames);
  return survey;
}

void write_survey(const survey::Survey& survey, const fs::path& folder) {
  base::write_file(folder / "survey.json", to_json(survey.manifest).dump() + "\n");
  try {
    write_frame_table(folder / "frames.csv", survey.frames);
    if (!survey.detections.empty()) write_detections(folder / "detections.csv", survey.detections);
    if (!survey.ties.empty()) write_ties(folder, survey.ties);
  } catch (Error& error) {
    error.default_file(folder.string());
    throw;
  }
}

void write_detections(const fs::path& path, std::span<const survey::Detection> detections) {
  CsvWriter table(path, kDetectionColumns);
  for (const auto& d : detections) {
    require_finite({d.score, d.box.xmin, d.box.ymin, d.box.xmax, d.box.ymax}, "detection " + text_of(d.id.value));
    table.cell(d.id.value).cell(d.frame.value).cell(d.object_class).cell(d.score);
    table.cell(d.box.xmin).cell(d.box.ymin).cell(d.box.xmax).cell(d.box.ymax);
    table.end_row();
  }
  table.finish();
}

std::vector<survey::Frame> read_frames(const fs::path& path) {
  FrameLines lines;
  return frames_of(path, nullptr, lines);
}

void write_frames(const fs::path& path, const std::vector<survey::Frame>& frames) {
  write_frame_table(path, frames);
}

geometry::RigidTransform exact_pose(const geometry::RigidTransform& pose) {
  return {exact_rotation(pose.rotation), pose.translation};
}

std::string file_reference(const fs::path& file, const fs::path& survey_folder) {
  const fs::path target = normal(file), folder = normal(survey_folder);
  if (starts_with(target, folder) || (folder.has_relative_path() && starts_with(target, folder.parent_path())))
    return target.lexically_relative(folder).generic_string();
  return target.generic_string();
}

fs::path resolve_reference(const std::string& reference, const fs::path& survey_folder) {
  if (reference.empty()) return {};
  const fs::path path(reference);
  return path.is_absolute() ? path : (survey_folder / path).lexically_normal();
}

}  // namespace cairn::io
