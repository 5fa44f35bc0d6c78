#include "io/tracks_csv.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <tuple>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/csv.hpp"

namespace cairn::io {
namespace {

constexpr std::array<std::string_view, 10> kColumns{"detection_id", "frame_id", "class",   "score",    "xmin_px",
                                                    "ymin_px",      "xmax_px",  "ymax_px", "track_id", "state"};

bool in_order(const survey::TrackedBox& a, const survey::TrackedBox& b) {
  return std::tie(a.box.frame, a.track) < std::tie(b.box.frame, b.track);
}

std::string record_of(const survey::TrackedBox& row) {
  return "track " + std::to_string(row.track.value) + ", frame " + std::to_string(row.box.frame.value);
}

}  // namespace

std::vector<survey::TrackedBox> read_tracks(const std::filesystem::path& path, const survey::Survey& survey) {
  CsvReader table(path);
  std::array<std::size_t, kColumns.size()> at{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) at[i] = table.column(kColumns[i]);
  std::vector<survey::TrackedBox> rows;
  while (table.next()) {
    survey::TrackedBox row;
    const auto state = survey::track_state_from(base::trim(table.text(at[9])));
    if (!state) throw table.error(at[9], "unknown state of a track").allowed("detected, coasted");
    row.state = *state;
    if (!base::trim(table.text(at[0])).empty()) row.box.id = survey::DetectionId(table.integer(at[0], 0, INT64_MAX));
    if (row.state == survey::TrackState::detected) {
      if (!row.box.id.valid()) throw table.error(at[0], "detected box without its detection").allowed("a detection id");
      if (!survey.detections.empty() && survey.detection(row.box.id) == nullptr)
        throw table.error(at[0], "box of an unknown detection")
            .allowed("a detection_id of the survey's detections.csv")
            .hint("Track this survey again with cairn track");
    }
    row.box.frame = survey::FrameId(table.integer(at[1], 0, INT64_MAX));
    if (survey.frame(row.box.frame) == nullptr)
      throw table.error(at[1], "track in an unknown frame").allowed("a frame_id of the survey's frames.csv");
    row.box.object_class = table.required(at[2]);
    row.box.score = table.real(at[3]);
    row.box.box = {table.real(at[4]), table.real(at[5]), table.real(at[6]), table.real(at[7])};
    if (row.box.box.width() < 0.0) throw table.error(at[6], "box ends before it begins").allowed("xmin_px or more");
    if (row.box.box.height() < 0.0) throw table.error(at[7], "box ends before it begins").allowed("ymin_px or more");
    row.track = survey::TrackId(table.integer(at[8], 0, INT64_MAX));
    rows.push_back(std::move(row));
  }
  std::stable_sort(rows.begin(), rows.end(), in_order);
  for (std::size_t i = 1; i < rows.size(); ++i)
    if (!in_order(rows[i - 1], rows[i]))
      throw base::Error(base::ErrorCode::invalid_input, "track has two boxes in one frame")
          .file(path.string())
          .record(record_of(rows[i]))
          .allowed("one row a track and frame");
  return rows;
}

void write_tracks(const std::filesystem::path& path, std::span<const survey::TrackedBox> tracks) {
  CsvWriter table(path, kColumns);
  for (const auto& row : tracks) {
    const auto& b = row.box;
    for (const double value : {b.score, b.box.xmin, b.box.ymin, b.box.xmax, b.box.ymax})
      if (!std::isfinite(value))
        throw base::Error(base::ErrorCode::invalid_input, "number is not finite")
            .file(path.string())
            .record(record_of(row));
    if (b.id.valid()) table.cell(b.id.value);
    else table.cell("");
    table.cell(b.frame.value).cell(b.object_class).cell(b.score);
    table.cell(b.box.xmin).cell(b.box.ymin).cell(b.box.xmax).cell(b.box.ymax);
    table.cell(row.track.value).cell(survey::name_of(row.state)).end_row();
  }
  table.finish();
}

}  // namespace cairn::io
