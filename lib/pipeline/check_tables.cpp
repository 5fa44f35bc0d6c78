#include "pipeline/check_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <set>

#include "base/number_text.hpp"
#include "io/csv.hpp"
#include "io/survey_folder.hpp"
#include "io/survey_json.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using io::CsvReader;
using io::Json;

constexpr double kQuaternionTolerance = 1e-3;  // of |q|: the bar of the strict reader
constexpr std::int64_t kMaxId = INT64_MAX;

// Fault of a record with its code.
struct Fault {
  std::string code;
  Error error;
};

// Columns of a table by name; a missing one is a fault of the table.
class Table {
 public:
  Table(const fs::path& path, Findings& findings) : path_(path), findings_(findings) {}

  // Opens; false (with a finding) where it cannot be read or a column is missing.
  bool open(std::initializer_list<const char*> columns) {
    try {
      reader_.emplace(path_);
      for (const char* name : columns) index_[name] = reader_->column(name);
      return true;
    } catch (Error& error) {
      error.default_file(path_.string());
      findings_.add(error.code() == ErrorCode::not_found ? "table_missing" : "table_malformed", error);
      return false;
    }
  }
  // Steps on; a malformed row ends the table with a finding.
  bool next() {
    try {
      return reader_->next();
    } catch (Error& error) {
      error.default_file(path_.string());
      findings_.add("table_malformed", error, "the rows behind it were not checked");
      return false;
    }
  }
  // Calls read() for the current row; its fault becomes a finding. Whether it had none.
  template <typename Read>
  bool row(std::string_view name, Read read) {
    try {
      read();
      return true;
    } catch (Fault& fault) {
      fault.error.default_file(path_.string());
      findings_.add(fault.code, fault.error, name);
    } catch (Error& error) {
      error.default_file(path_.string());
      findings_.add("cell_invalid", error, name);
    }
    return false;
  }

  [[nodiscard]] const CsvReader& reader() const { return *reader_; }
  [[nodiscard]] std::size_t at(const char* column) const { return index_.at(column); }
  [[nodiscard]] double real(const char* column) const { return reader_->real(at(column)); }
  [[nodiscard]] std::int64_t id(const char* column) const { return reader_->integer(at(column), 0, kMaxId); }
  [[nodiscard]] std::string_view text(const char* column) const { return base::trim(reader_->text(at(column))); }
  [[nodiscard]] Error error(const char* column, std::string message) const {
    return reader_->error(at(column), std::move(message));
  }
  [[nodiscard]] std::string line() const { return "line " + std::to_string(reader_->line()); }

 private:
  fs::path path_;
  Findings& findings_;
  std::optional<CsvReader> reader_;
  std::map<std::string, std::size_t> index_;
};

template <typename Id>
void require_new(std::set<Id>& ids, Id id, const Table& table, const char* column) {
  if (!ids.insert(id).second)
    throw Fault{"duplicate_id", table.error(column, "id appears twice").hint("Give every record its own id")};
}

template <typename Record>
void sort_by_id(std::vector<Record>& records) {
  std::stable_sort(records.begin(), records.end(), [](const Record& a, const Record& b) { return a.id < b.id; });
}

geometry::RigidTransform pose_of(const Table& table) {
  constexpr std::array<const char*, 7> kPose{"x_m", "y_m", "z_m", "qw", "qx", "qy", "qz"};
  std::array<double, 7> value{};
  for (std::size_t i = 0; i < kPose.size(); ++i) {
    const std::string_view text = table.text(kPose[i]);
    if (text.empty())
      throw Fault{"frame_without_pose", table.error(kPose[i], "frame without a pose")
                                            .allowed("x_m, y_m, z_m and qw, qx, qy, qz of T_world_camera")
                                            .hint("Give the frame its pose, or take it out of frames.csv")};
    const auto number = base::parse_real(text);
    if (number && !std::isfinite(*number))
      throw Fault{"pose_not_finite", table.error(kPose[i], "pose is not a finite number")
                                         .found(text)
                                         .allowed("a finite number")
                                         .hint("Import the poses again, or take the frame out of frames.csv")};
    value[i] = table.real(kPose[i]);
  }
  const geometry::Quaternion q{value[3], value[4], value[5], value[6]};
  if (!(std::abs(q.norm() - 1.0) <= kQuaternionTolerance))
    throw Fault{"quaternion_not_unit",
                table.error("qw", "quaternion is not of unit length")
                    .found("|q| = " + base::to_text(q.norm()))
                    .allowed("1 within " + base::to_text(kQuaternionTolerance))
                    .hint("Check the order of the columns qw, qx, qy, qz and that all four are there")};
  return {geometry::rotation_matrix(q), {value[0], value[1], value[2]}};
}

double sigma_of(const Table& table, const char* column) {
  const auto value = table.reader().optional_real(table.at(column));
  if (value && *value < 0.0)
    throw Fault{"cell_invalid",
                table.error(column, "standard deviation is negative").allowed("0 or more; empty = not known")};
  return value.value_or(0.0);
}

void read_frames(const fs::path& folder, CheckedSurvey& checked, std::set<survey::FrameId>& known, Findings& findings) {
  Table table(folder / "frames.csv", findings);
  if (!table.open({"frame_id", "time_ns", "camera_id", "image", "x_m", "y_m", "z_m", "qw", "qx", "qy", "qz",
                   "sigma_xy_m", "sigma_z_m", "sigma_rot_deg"}))
    return;
  auto& survey = checked.survey;
  while (table.next()) {
    ++checked.frame_rows;
    survey::Frame frame;
    const std::string image = fs::path(table.text("image")).filename().string();
    const std::string name = "frame " + std::string(table.text("frame_id")) + (image.empty() ? "" : ", " + image);
    const bool good = table.row(name, [&] {
      frame.id = survey::FrameId(table.id("frame_id"));
      require_new(known, frame.id, table, "frame_id");
      frame.image = table.text("image");
      frame.time_ns = table.text("time_ns").empty() ? 0 : table.reader().integer(table.at("time_ns"));
      frame.T_world_camera = pose_of(table);
      frame.sigma_xy_m = sigma_of(table, "sigma_xy_m");
      frame.sigma_z_m = sigma_of(table, "sigma_z_m");
      frame.sigma_rot_deg = sigma_of(table, "sigma_rot_deg");
      frame.camera = survey::CameraId(table.id("camera_id"));
      if (survey.camera(frame.camera) == nullptr)
        throw Fault{"unknown_camera", table.error("camera_id", "frame of an unknown camera")
                                          .found(table.text("camera_id"))
                                          .allowed("a camera id of survey.json")
                                          .hint("Add the camera to survey.json, or name one that is there")};
    });
    if (!good) continue;
    checked.frame_records[frame.id] = table.line() + " (" + name + ")";
    survey.frames.push_back(std::move(frame));
  }
  sort_by_id(survey.frames);
}

void require_frame(const std::set<survey::FrameId>& known, survey::FrameId frame, const Table& table,
                   std::string_view what) {
  if (!known.contains(frame))
    throw Fault{"unknown_frame", table.error("frame_id", std::string(what) + " of an unknown frame")
                                     .found(std::to_string(frame.value))
                                     .allowed("one of the " + std::to_string(known.size()) + " frames of frames.csv")
                                     .hint("Remove the row, or add the frame with its pose")};
}

void read_detections(const fs::path& folder, CheckedSurvey& checked, const std::set<survey::FrameId>& frames,
                     Findings& findings) {
  Table table(folder / "detections.csv", findings);
  if (!table.open({"detection_id", "frame_id", "class", "score", "xmin_px", "ymin_px", "xmax_px", "ymax_px"})) return;
  std::set<survey::DetectionId> known;
  while (table.next()) {
    ++checked.detection_rows;
    survey::Detection d;
    const std::string name = "detection " + std::string(table.text("detection_id"));
    const bool good = table.row(name, [&] {
      d.id = survey::DetectionId(table.id("detection_id"));
      require_new(known, d.id, table, "detection_id");
      d.frame = survey::FrameId(table.id("frame_id"));
      require_frame(frames, d.frame, table, "detection");
      d.object_class = table.reader().required(table.at("class"));
      d.score = table.real("score");
      if (d.score < 0.0 || d.score > 1.0)
        throw Fault{"score_out_of_range", table.error("score", "score out of range").allowed("0 to 1")};
      d.box = {table.real("xmin_px"), table.real("ymin_px"), table.real("xmax_px"), table.real("ymax_px")};
      const char* last = d.box.xmax < d.box.xmin ? "xmax_px" : d.box.ymax < d.box.ymin ? "ymax_px" : nullptr;
      if (last != nullptr)
        throw Fault{"box_inverted", table.error(last, "box ends before it begins")
                                        .allowed("xmin_px <= xmax_px and ymin_px <= ymax_px")
                                        .hint("Boxes are corners, not corner and size")};
    });
    if (!good) continue;
    checked.detection_records[d.id] = table.line() + " (" + name + ")";
    checked.survey.detections.push_back(std::move(d));
  }
  sort_by_id(checked.survey.detections);
}

void read_ties(const fs::path& folder, CheckedSurvey& checked, const std::set<survey::FrameId>& frames,
               Findings& findings) {
  auto& ties = checked.survey.ties;
  std::set<survey::TiePointId> known;
  Table points(folder / "tie_points.csv", findings);
  if (!points.open({"tie_id", "x_m", "y_m", "z_m"})) return;
  while (points.next()) {
    ++checked.tie_rows;
    survey::TiePoint tie;
    const bool good = points.row("tie point " + std::string(points.text("tie_id")), [&] {
      tie.id = survey::TiePointId(points.id("tie_id"));
      require_new(known, tie.id, points, "tie_id");
      tie.p_world = {points.real("x_m"), points.real("y_m"), points.real("z_m")};
    });
    if (good) ties.push_back(std::move(tie));
  }
  sort_by_id(ties);
  Table observations(folder / "tie_observations.csv", findings);
  if (!observations.open({"tie_id", "frame_id", "u_px", "v_px"})) return;
  while (observations.next()) {
    ++checked.observation_rows;
    observations.row("observation", [&] {
      const survey::TiePointId id(observations.id("tie_id"));
      if (!known.contains(id))
        throw Fault{"unknown_tie", observations.error("tie_id", "observation of an unknown tie point")
                                       .found(std::to_string(id.value))
                                       .allowed("a tie_id of tie_points.csv")};
      const survey::FrameId frame(observations.id("frame_id"));
      require_frame(frames, frame, observations, "observation");
      const geometry::Vec2 pixel(observations.real("u_px"), observations.real("v_px"));
      const auto it = std::lower_bound(ties.begin(), ties.end(), id,
                                       [](const survey::TiePoint& t, survey::TiePointId w) { return t.id < w; });
      if (it != ties.end() && it->id == id) it->observations.push_back({frame, pixel});
    });
  }
}

Json placeholder_origin() {
  return Json::object({{"latitude_deg", 0.0}, {"longitude_deg", 0.0}, {"height_m", 0.0}, {"height_type", "unknown"}});
}

// Members that can be used, each fault a finding: cameras and sources are tried one by one.
void read_manifest(const fs::path& folder, CheckedSurvey& checked, Findings& findings) {
  const std::string name = (folder / "survey.json").string();
  Json json;
  try {
    json = io::read_json(name);
    if (json.find("schema_version") == nullptr) throw Error(ErrorCode::invalid_input, "not a survey").file(name);
  } catch (Error& error) {
    error.default_file(name);
    findings.add("survey_json", error);
    return;
  }
  const auto attempt = [&](const std::string& code, const std::string& record, auto&& read) {
    try {
      read();
      return true;
    } catch (Error& error) {
      error.default_file(name);
      findings.add(code, error, record);
      return false;
    }
  };
  Json usable = json;
  checked.has_origin =
      attempt("origin_out_of_range", "origin", [&] { static_cast<void>(io::origin_from_json(json.at("origin"))); });
  if (!checked.has_origin) usable.set("origin", placeholder_origin());
  Json cameras = Json::array(), sources = Json::array();
  const auto each = [](const Json* list, auto&& take) {
    if (list != nullptr && list->is_array())
      for (std::size_t i = 0; i < list->as_array().size(); ++i) take(i + 1, list->as_array()[i]);
  };
  each(json.find("cameras"), [&](std::size_t number, const Json& item) {
    if (attempt("camera_invalid", "camera " + std::to_string(number) + " of the list",
                [&] { static_cast<void>(io::camera_from_json(item)); }))
      cameras.push(item);
  });
  usable.set("cameras", cameras);
  each(json.find("sources"), [&](std::size_t number, const Json& item) {
    Json alone = usable;
    alone.set("cameras", Json::array());
    Json one = Json::array();
    one.push(item);
    alone.set("sources", std::move(one));
    if (attempt("source_invalid", "source " + std::to_string(number) + " of the list",
                [&] { static_cast<void>(io::manifest_from_json(alone, name)); }))
      sources.push(item);
  });
  usable.set("sources", sources);
  attempt("survey_json", "", [&] { checked.survey.manifest = io::manifest_from_json(usable, name); });
}

}  // namespace

CheckedSurvey read_for_check(const fs::path& folder, Findings& findings) {
  CheckedSurvey checked;
  read_manifest(folder, checked, findings);
  std::set<survey::FrameId> frames;
  read_frames(folder, checked, frames, findings);
  std::error_code code;
  if (fs::exists(folder / "detections.csv", code)) read_detections(folder, checked, frames, findings);
  if (fs::exists(folder / "tie_points.csv", code)) read_ties(folder, checked, frames, findings);
  // A fault of the strict reader that the checks above do not know must not pass.
  if (findings.count(Severity::error) == 0) {
    try {
      static_cast<void>(io::read_survey(folder));
    } catch (Error& error) {
      error.default_file(folder.string());
      findings.add("survey_unreadable", error);
    }
  }
  return checked;
}

}  // namespace cairn::pipeline
