#include "pipeline/import_survey.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/local_frame.hpp"
#include "io/colmap_model.hpp"
#include "io/csv.hpp"
#include "io/survey_folder.hpp"
#include "io/survey_json.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::optional<std::int64_t> trailing_number(const std::string& image_name) {
  const std::string stem = fs::path(image_name).stem().string();
  const auto last = stem.find_last_not_of("0123456789");
  const std::string digits = last == std::string::npos ? stem : stem.substr(last + 1);
  constexpr std::size_t kMaxDigits = 9;
  if (digits.empty() || digits.size() > kMaxDigits) return std::nullopt;
  return base::parse_integer(digits);
}

// Indices of frames by whole image name and by its last part; -1 = the last part is not unique.
std::map<std::string, std::ptrdiff_t, std::less<>> frames_by_name(const std::vector<std::string>& names) {
  std::map<std::string, std::ptrdiff_t, std::less<>> index;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto [it, fresh] = index.emplace(fs::path(names[i]).filename().string(), static_cast<std::ptrdiff_t>(i));
    if (!fresh) it->second = -1;
  }
  for (std::size_t i = 0; i < names.size(); ++i) index[names[i]] = static_cast<std::ptrdiff_t>(i);
  return index;
}

void require_declared(const survey::Survey& survey) {
  std::string assumed;
  for (const auto& source : survey.manifest.sources)
    if (source.confidence == survey::Confidence::assumed)
      assumed += (assumed.empty() ? "" : " ") + source.kind + ": " + source.convention;
  if (!assumed.empty())
    throw Error(ErrorCode::failed_precondition, "an assumed convention is not accepted with --strict")
        .found(assumed)
        .hint("Declare the convention, or leave --strict out");
}

void sort_records(Imported& imported) {
  auto& frames = imported.survey.frames;
  std::vector<std::size_t> order(frames.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return frames[a].id < frames[b].id; });
  Imported sorted;
  for (const std::size_t i : order) {
    sorted.survey.frames.push_back(std::move(frames[i]));
    sorted.image_names.push_back(std::move(imported.image_names[i]));
    sorted.image_files.push_back(std::move(imported.image_files[i]));
  }
  frames = std::move(sorted.survey.frames);
  imported.image_names = std::move(sorted.image_names);
  imported.image_files = std::move(sorted.image_files);
}

void place_images(Imported& imported, const ImportInputs& in, const fs::path& out) {
  for (std::size_t i = 0; i < imported.survey.frames.size(); ++i) {
    auto& frame = imported.survey.frames[i];
    const fs::path& file = imported.image_files[i];
    if (file.empty()) continue;
    if (!in.copy_images) {
      frame.image = io::file_reference(file, in.survey_folder);
      continue;
    }
    const fs::path target = fs::path("images") / fs::path(imported.image_names[i]).relative_path().lexically_normal();
    if (*std::next(target.begin()) == "..")
      throw Error(ErrorCode::invalid_input, "image name leads out of the survey folder")
          .record("frame " + std::to_string(frame.id.value))
          .found(imported.image_names[i]);
    std::error_code code;
    fs::create_directories((out / target).parent_path(), code);
    fs::copy_file(file, out / target, code);
    if (code)
      throw Error(ErrorCode::resource_exhausted, "cannot copy the image: " + code.message()).file(file.string());
    frame.image = target.generic_string();
  }
}

io::Json summary_of(const survey::Survey& survey, const std::vector<base::Reject>& rejects) {
  const auto& origin = survey.manifest.origin;
  std::size_t observations = 0;
  for (const auto& tie : survey.ties) observations += tie.observations.size();
  io::Json sources = io::Json::array();
  for (const auto& source : survey.manifest.sources)
    sources.push(io::Json::object({{"kind", source.kind},
                                   {"convention", source.convention},
                                   {"confidence", survey::name_of(source.confidence)}}));
  return io::Json::object({{"name", survey.manifest.name},
                           {"frames", survey.frames.size()},
                           {"cameras", survey.manifest.cameras.size()},
                           {"detections", survey.detections.size()},
                           {"tie_points", survey.ties.size()},
                           {"tie_observations", observations},
                           {"origin", io::to_json(origin)},
                           {"sources", std::move(sources)},
                           {"notes", io::Json(survey.manifest.notes)},
                           {"rejected_frames", rejects.size()}});
}

}  // namespace

geometry::Geodetic parse_origin(std::string_view text) {
  std::vector<double> values;
  std::string_view rest = text;
  while (true) {
    const auto comma = rest.find(',');
    const auto value = base::parse_real(rest.substr(0, comma));
    if (!value || !std::isfinite(*value) || values.size() == 3)
      throw Error(ErrorCode::invalid_argument, "not an origin")
          .found("'" + std::string(text) + "'")
          .allowed("LAT,LON,HEIGHT in degrees and metres, for example 46.8426,-91.9940,158.0");
    values.push_back(*value);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (values.size() != 3)
    throw Error(ErrorCode::invalid_argument, "origin of the wrong length")
        .found(std::to_string(values.size()) + " numbers")
        .allowed("LAT,LON,HEIGHT");
  const geometry::Geodetic origin{values[0], values[1], values[2]};
  const geodesy::LocalFrame checked(origin);  // refuses a position off the globe
  return origin;
}

survey::Camera parse_camera(const std::string& text) {
  const auto refuse = [&](std::string message) {
    return Error(ErrorCode::invalid_argument, std::move(message))
        .found("'" + text + "'")
        .allowed("MODEL,WIDTH,HEIGHT,PARAMETERS, for example PINHOLE,1600,900,914.3,914.3,800,450");
  };
  std::vector<double> numbers;
  std::string_view rest = text;
  const auto name_end = std::min(rest.find_first_of(", "), rest.size());
  const io::ColmapCameraModel* model = io::find_colmap_model(rest.substr(0, name_end));
  if (model == nullptr) throw refuse("unknown camera model");
  rest.remove_prefix(name_end);
  while (!rest.empty()) {
    rest.remove_prefix(1);
    const auto end = std::min(rest.find_first_of(", "), rest.size());
    const auto value = base::parse_real(rest.substr(0, end));
    if (!value) throw refuse("not a camera");
    numbers.push_back(*value);
    rest.remove_prefix(end);
  }
  if (numbers.size() < 2) throw refuse("not a camera");
  try {
    survey::Camera camera = io::make_colmap_camera(1, *model, numbers[0], numbers[1], std::span(numbers).subspan(2));
    camera.name = "camera 1";
    return camera;
  } catch (const Error& error) {
    throw refuse(error.what());
  }
}

std::vector<survey::FrameId> frame_ids_for(const std::vector<std::string>& image_names) {
  std::vector<survey::FrameId> ids;
  std::set<std::int64_t> seen;
  for (const auto& name : image_names) {
    const auto number = trailing_number(name);
    if (!number || !seen.insert(*number).second) break;
    ids.emplace_back(*number);
  }
  if (ids.size() == image_names.size()) return ids;
  std::vector<std::size_t> order(image_names.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return image_names[a] < image_names[b]; });
  ids.assign(image_names.size(), survey::FrameId());
  for (std::size_t rank = 0; rank < order.size(); ++rank)
    ids[order[rank]] = survey::FrameId(static_cast<std::int64_t>(rank) + 1);
  return ids;
}

std::vector<fs::path> list_images(const fs::path& folder) {
  std::error_code code;
  if (!fs::is_directory(folder, code))
    throw Error(ErrorCode::not_found, "no such folder of images").file(folder.string()).hint("Check the path");
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string extension = lower(entry.path().extension().string());
    if (entry.is_regular_file() && (extension == ".jpg" || extension == ".jpeg" || extension == ".png"))
      images.push_back(entry.path());
  }
  if (images.empty())
    throw Error(ErrorCode::not_found, "no images in the folder")
        .file(folder.string())
        .allowed("files .jpg, .jpeg, .png");
  std::sort(images.begin(), images.end());
  return images;
}

void attach_detections(Imported& imported, const fs::path& path, double scale, const fs::path& survey_folder) {
  if (!(scale > 0.0) || !std::isfinite(scale))
    throw Error(ErrorCode::invalid_argument, "scale of the detections is not positive")
        .found(base::to_text(scale))
        .allowed("more than 0");
  io::CsvReader table(path);
  const auto image = table.column("image"), name = table.column("class"), xmin = table.column("xmin_px"),
             ymin = table.column("ymin_px"), xmax = table.column("xmax_px"), ymax = table.column("ymax_px"),
             score = table.column("score");
  const auto index = frames_by_name(imported.image_names);
  auto& detections = imported.survey.detections;
  while (table.next()) {
    survey::Detection d;
    d.id = survey::DetectionId(static_cast<std::int64_t>(detections.size()) + 1);
    const auto it = index.find(table.required(image));
    if (it == index.end())
      throw table.error(image, "detection of an unknown frame")
          .allowed("the image name of one of the " + std::to_string(imported.image_names.size()) + " frames")
          .hint("Remove the row, or import the image with its pose");
    if (it->second < 0)
      throw table.error(image, "several frames have an image of this name").hint("Name the image with its folder");
    d.frame = imported.survey.frames[static_cast<std::size_t>(it->second)].id;
    d.object_class = table.required(name);
    d.score = table.real(score);
    if (d.score < 0.0 || d.score > 1.0) throw table.error(score, "score out of range").allowed("0 to 1");
    d.box = {table.real(xmin), table.real(ymin), table.real(xmax), table.real(ymax)};
    if (d.box.xmax < d.box.xmin) throw table.error(xmax, "box ends before it begins").allowed("xmin_px or more");
    if (d.box.ymax < d.box.ymin) throw table.error(ymax, "box ends before it begins").allowed("ymin_px or more");
    for (double* side : {&d.box.xmin, &d.box.ymin, &d.box.xmax, &d.box.ymax}) *side *= scale;
    detections.push_back(std::move(d));
  }
  survey::Source source;
  source.kind = "detections";
  source.path = io::file_reference(path, survey_folder);
  source.convention =
      "Boxes as xmin, ymin, xmax, ymax with the first pixel's centre at (0.5, 0.5) in the raw image, "
      "multiplied by " +
      base::to_text(scale) + " to the pixels of the image files.";
  source.confidence = survey::Confidence::inferred;
  imported.survey.manifest.sources.push_back(std::move(source));
}

geometry::Similarity read_similarity(const fs::path& path, const survey::Origin& origin) {
  const io::Json json = io::read_json(path);
  try {
    if (const io::Json* there = json.find("origin")) {
      const geometry::Geodetic named{there->at("latitude_deg").as_real(), there->at("longitude_deg").as_real(),
                                     there->at("height_m").as_real()};
      if (!(named == origin.position))
        throw Error(ErrorCode::crs_mismatch, "similarity is for another local frame")
            .file(path.string())
            .found("origin " + base::to_text(named.latitude_deg) + "," + base::to_text(named.longitude_deg) + "," +
                   base::to_text(named.height_m))
            .allowed("origin " + base::to_text(origin.position.latitude_deg) + "," +
                     base::to_text(origin.position.longitude_deg) + "," + base::to_text(origin.position.height_m))
            .hint("Import with the origin of the similarity");
    }
    if (const io::Json* forward = json.find("colmap_enu_to_cloud_enu"))
      return io::similarity_from_json(*forward).inverse();
    const std::string& direction = json.at("direction").as_string();
    if (direction == "source_to_world") return io::similarity_from_json(json);
    if (direction == "world_to_source") return io::similarity_from_json(json).inverse();
    throw Error(ErrorCode::invalid_input, "unknown direction of the similarity")
        .found("'" + direction + "'")
        .allowed("world_to_source, source_to_world");
  } catch (Error& error) {
    error.default_file(path.string());
    throw;
  }
}

Outcome finish_import(Imported imported, const ImportInputs& in, double default_detections_scale, const fs::path& out,
                      base::RunContext& ctx) {
  auto& survey = imported.survey;
  if (survey.frames.empty())
    throw Error(ErrorCode::invalid_input, "no frame could be imported")
        .found(imported.rejects.empty() ? "no frames" : imported.rejects.front().message);
  survey.manifest.name =
      in.name.empty() ? fs::absolute(in.survey_folder).lexically_normal().filename().string() : in.name;
  if (survey.manifest.name.empty()) survey.manifest.name = "survey";
  for (auto& frame : survey.frames) frame.T_world_camera = io::exact_pose(frame.T_world_camera);
  sort_records(imported);
  if (!in.detections.empty()) {
    const double scale = in.detections_scale.value_or(default_detections_scale);
    const bool table = in.detections_format == "csv" ||
                       (in.detections_format == "auto" && lower(in.detections.extension().string()) == ".csv");
    if (table) attach_detections(imported, in.detections, scale, in.survey_folder);
    else attach_boxes(imported, in, scale);
  }
  if (!in.cloud.empty()) attach_cloud(imported, in);
  if (in.strict) require_declared(survey);
  for (const auto& source : survey.manifest.sources)
    if (source.confidence == survey::Confidence::assumed) ctx.warn(source.kind + ": assumed: " + source.convention);
  for (const auto& note : survey.manifest.notes) ctx.warn(note);
  for (const auto& reject : imported.rejects) ctx.warn(reject.record + ": " + reject.message);
  place_images(imported, in, out);
  io::write_survey(survey, out);
  return {summary_of(survey, imported.rejects), imported.rejects};
}

}  // namespace cairn::pipeline
