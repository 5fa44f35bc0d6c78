// Survey folders for `cairn check`: the Brighton Beach sample as cairn writes it, to be spoilt by tests.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "io/json.hpp"
#include "io/las.hpp"
#include "io/survey_folder.hpp"
#include "support/brighton_beach.hpp"

namespace cairn::testing {

inline std::filesystem::path brighton_image(int number) {
  return sample("brighton_beach/images_1600/DJI_00" + std::to_string(number) + ".JPG");
}

inline survey::Source cloud_source(const std::filesystem::path& path) {
  survey::Source source;
  source.kind = "cloud";
  source.path = path.string();
  source.convention = "points in the CRS of the file";
  return source;
}

// cloud <- colmap_enu of enu_frame.json.
inline geometry::Similarity brighton_cloud_from_enu() {
  const auto json = io::read_json(sample("brighton_beach/enu_frame.json")).at("colmap_enu_to_cloud_enu");
  geometry::Similarity T;
  T.scale = json.at("scale").as_real();
  for (std::size_t r = 0; r < 3; ++r)
    T.rotation.row(static_cast<int>(r)) = json.at("rotation").as_array()[r].as_vec3().transpose();
  T.translation = json.at("translation_m").as_vec3();
  return T;
}

// Poses and ties of COLMAP, images of 1600 px, the sample's cloud with or without its similarity.
inline survey::Survey check_colmap_survey(bool cloud, bool similarity) {
  auto survey = brighton_beach_colmap();
  survey.manifest.name = "brighton_beach";
  survey.manifest.origin.height_type = survey::HeightType::ellipsoidal;
  for (auto& frame : survey.frames) frame.image = sample("brighton_beach/images_1600/" + frame.image).string();
  if (cloud) {
    auto source = cloud_source(sample("brighton_beach/model.las"));
    if (similarity) source.T_world_source = brighton_cloud_from_enu().inverse();
    survey.manifest.sources.push_back(source);
  }
  return survey;
}

// A few frames, ties and boxes without pixels or cloud to prove: fast to check.
inline survey::Survey check_small_survey() {
  auto survey = check_colmap_survey(false, false);
  survey.frames.resize(4);
  std::erase_if(survey.ties, [&](survey::TiePoint& tie) {
    std::erase_if(tie.observations, [&](const auto& o) { return survey.frame(o.frame) == nullptr; });
    return tie.observations.size() < 2;
  });
  for (int i = 0; i < 3; ++i) {
    survey::Detection d;
    d.id = survey::DetectionId(i + 1);
    d.frame = survey.frames[1].id;
    d.object_class = "boulder";
    d.score = 0.9;
    d.box = {100.0 + 50.0 * i, 100.0, 140.0 + 50.0 * i, 150.0};
    survey.detections.push_back(d);
  }
  return survey;
}

inline void write_check_survey(const survey::Survey& survey, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  io::write_survey(survey, folder);
}

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

// Replaces cell `column` (0-based) of data row `row` (0-based); the tables of these tests quote nothing.
inline void replace_cell(const std::filesystem::path& table, std::size_t row, std::size_t column,
                         const std::string& value) {
  const std::string text = read_text(table);
  std::size_t line = text.find('\n') + 1;
  for (std::size_t i = 0; i < row; ++i) line = text.find('\n', line) + 1;
  std::size_t from = line;
  for (std::size_t i = 0; i < column; ++i) from = text.find(',', from) + 1;
  const std::size_t to = text.find_first_of(",\n", from);
  write_text(table, text.substr(0, from) + value + text.substr(to));
}

}  // namespace cairn::testing
