#include "io/control_points.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geodesy/crs.hpp"
#include "io/csv.hpp"
#include "io/json.hpp"
#include "io/opensfm.hpp"

namespace cairn::io {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Vec2;
using geometry::Vec3;

// One observation as the file has it.
struct Row {
  std::string record;  // "line 3"
  std::string name;
  std::optional<Vec3> place;  // in the file's CRS; a height that is not known is NaN
  std::string image;
  Vec2 pixel = Vec2::Zero();
  bool normalised = false;  // `pixel` is in OpenSfM's coordinates
  double sigma_xy_m = 0.0, sigma_z_m = 0.0;
  bool check_only = false;
};

std::string lower(std::string_view text) {
  std::string result(text);
  for (auto& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBlanks = " \t\r";
  while (true) {
    const auto from = line.find_first_not_of(kBlanks);
    if (from == std::string_view::npos) return words;
    const auto to = line.find_first_of(kBlanks, from);
    words.push_back(line.substr(from, to == std::string_view::npos ? to : to - from));
    if (to == std::string_view::npos) return words;
    line.remove_prefix(to);
  }
}

std::vector<Row> rows_of_gcp_list(const std::string& text, const fs::path& path, std::string& crs) {
  std::vector<Row> rows;
  std::map<std::string, std::string> name_by_place;
  std::string_view rest = text;
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  if (rest.starts_with(kMark)) rest.remove_prefix(kMark.size());
  std::size_t number = 0;
  bool header = false;
  while (!rest.empty()) {
    const auto end = rest.find('\n');
    const std::string_view line = base::trim(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    ++number;
    if (line.empty() || line.front() == '#') continue;
    const std::string record = "line " + std::to_string(number);
    if (!header) {
      header = true;
      try {
        if (crs.empty()) crs = gcp_crs(line);
      } catch (Error& error) {
        error.default_file(path.string());
        throw;
      }
      continue;
    }
    const auto words = words_of(line);
    constexpr std::size_t kLeast = 6, kImage = 5, kName = 6;
    if (words.size() < kLeast)
      throw Error(ErrorCode::invalid_input, "a row of ground control has too few columns")
          .file(path.string())
          .record(record)
          .found(std::to_string(words.size()))
          .allowed("x y z px py image [name]");
    double values[5];
    for (std::size_t i = 0; i < 5; ++i) {
      const auto value = base::parse_real(words[i]);
      const bool no_height = i == 2 && lower(words[i]) == "nan";
      if (!no_height && (!value || !std::isfinite(*value)))
        throw Error(ErrorCode::invalid_input, "a coordinate of ground control is not a number")
            .file(path.string())
            .record(record)
            .found("'" + std::string(words[i]) + "'")
            .allowed("x y z px py image [name]");
      values[i] = no_height ? std::nan("") : *value;
    }
    Row row;
    row.record = record;
    row.place = Vec3(values[0], values[1], values[2]);
    constexpr double kHalfPixel = 0.5;
    row.pixel = Vec2(values[3] + kHalfPixel, values[4] + kHalfPixel);
    row.image = words[kImage];
    if (words.size() > kName) {
      row.name = words[kName];
    } else {
      const std::string place = std::string(words[0]) + " " + std::string(words[1]) + " " + std::string(words[2]);
      row.name = name_by_place.emplace(place, "gcp" + std::to_string(name_by_place.size() + 1)).first->second;
    }
    rows.push_back(std::move(row));
  }
  if (!header) throw Error(ErrorCode::invalid_input, "the list of ground control is empty").file(path.string());
  return rows;
}

std::vector<Row> rows_of_opensfm(const std::string& text, const fs::path& path, std::string& crs) {
  if (crs.empty()) crs = "EPSG:4326";
  std::vector<Row> rows;
  try {
    const Json json = parse_json(text, path.string());
    std::size_t number = 0;
    for (const auto& point : json.at("points").as_array()) {
      Row row;
      row.record = "point " + std::to_string(++number);
      row.name = point.at("id").is_integer() ? std::to_string(point.at("id").as_integer()) : point.at("id").as_string();
      if (const Json* place = point.find("position"); place != nullptr && !place->is_null()) {
        const Json* altitude = place->find("altitude");
        row.place = Vec3(place->at("longitude").as_real(), place->at("latitude").as_real(),
                         altitude == nullptr || altitude->is_null() ? std::nan("") : altitude->as_real());
      }
      if (const Json* role = point.find("role"); role != nullptr && role->is_string())
        row.check_only = role->as_string() == "metrics_only";
      row.normalised = true;
      for (const auto& seen : point.at("observations").as_array()) {
        row.image = seen.at("shot_id").as_string();
        const auto& at = seen.at("projection").as_array();
        if (at.size() != 2)
          throw Error(ErrorCode::invalid_input, "a projection has not two numbers").record(row.record);
        row.pixel = Vec2(at[0].as_real(), at[1].as_real());
        rows.push_back(row);
      }
    }
  } catch (Error& error) {
    error.default_file(path.string());
    throw;
  }
  return rows;
}

std::vector<Row> rows_of_csv(const fs::path& path, const ControlPointOptions& options, std::string& crs) {
  CsvReader csv(path);
  for (const auto& comment : csv.comments())
    if (crs.empty() && lower(comment).starts_with("crs:")) crs = base::trim(std::string_view(comment).substr(4));
  const auto name = csv.column("name"), x = csv.column("x"), y = csv.column("y"), z = csv.column("z");
  const auto image = csv.column("image"), u = csv.column("x_px"), v = csv.column("y_px");
  const auto sigma_xy = csv.find("sigma_xy_m"), sigma_z = csv.find("sigma_z_m"), use = csv.find("use");
  const auto sigma = [&](const std::optional<std::size_t>& column, double fallback) {
    const auto value = column ? csv.optional_real(*column) : std::nullopt;
    if (value && !(*value > 0.0)) throw csv.error(*column, "a sigma is not positive").allowed("more than 0");
    return value.value_or(fallback);
  };
  std::vector<Row> rows;
  while (csv.next()) {
    Row row;
    row.record = "line " + std::to_string(csv.line());
    row.name = csv.required(name);
    row.place = Vec3(csv.real(x), csv.real(y), csv.optional_real(z).value_or(std::nan("")));
    row.image = csv.required(image);
    row.pixel = Vec2(csv.real(u), csv.real(v));
    row.sigma_xy_m = sigma(sigma_xy, options.sigma_xy_m);
    row.sigma_z_m = sigma(sigma_z, options.sigma_z_m);
    if (use) {
      const auto text = csv.text(*use);
      if (text != "" && text != "control" && text != "check")
        throw csv.error(*use, "a point's use is not known").allowed("control, check");
      row.check_only = text == "check";
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// World from the file's CRS.
class Placer {
 public:
  Placer(const std::string& crs, const survey::Survey& survey, const fs::path& path)
      : frame_(survey.manifest.origin.position) {
    if (crs == "local") return;
    if (crs.empty())
      throw Error(ErrorCode::crs_mismatch, "the ground control has no CRS")
          .file(path.string())
          .hint("Add a line '# crs: EPSG:n' before the header, or give --control-crs");
    const bool vertical = geodesy::describe_crs(crs).has_vertical;
    const auto type = survey.manifest.origin.height_type;
    if (vertical && type != survey::HeightType::ellipsoidal)
      throw Error(ErrorCode::crs_mismatch, "the ground control's heights are of another datum than the survey's")
          .file(path.string())
          .found(crs)
          .allowed("heights of the survey: " + std::string(survey::name_of(type)))
          .hint("Import the survey with ellipsoidal heights, or give the points' CRS without its vertical part");
    geodesy::CrsOptions options;
    options.heights = vertical ? geodesy::Heights::to_ellipsoid : geodesy::Heights::keep_datum;
    converter_.emplace(crs, frame_, options);
    how_ = vertical ? "heights converted to the ellipsoid (" + converter_->operation() + ")"
                    : "heights taken as " + std::string(survey::name_of(type)) + ", as the survey's";
  }

  [[nodiscard]] Vec3 to_local(const Vec3& place) const { return converter_ ? converter_->to_local(place) : place; }
  [[nodiscard]] std::string how() const { return converter_ ? how_ : "local coordinates as they are"; }

 private:
  geodesy::LocalFrame frame_;
  std::optional<geodesy::CrsConverter> converter_;
  std::string how_;
};

}  // namespace

std::string gcp_crs(std::string_view header) {
  const std::string text(base::trim(header));
  const auto words = words_of(text);
  const auto bad = [&] {
    return Error(ErrorCode::crs_mismatch, "the first line of the ground control names no CRS")
        .found("'" + text + "'")
        .allowed("EPSG:n, WGS84, WGS84 UTM 16N, or a PROJ string");
  };
  if (words.empty()) throw bad();
  const std::string first = lower(words[0]);
  if (first.starts_with("epsg:")) return "EPSG:" + std::string(words[0].substr(5));
  if (first.starts_with("+")) return text.find("+type=crs") == std::string::npos ? text + " +type=crs" : text;
  if (first != "wgs84") throw bad();
  if (words.size() == 1) return "EPSG:4326";
  constexpr std::size_t kWords = 3;
  if (words.size() != kWords || lower(words[1]) != "utm" || words[2].size() < 2) throw bad();
  const char side = static_cast<char>(std::toupper(static_cast<unsigned char>(words[2].back())));
  const auto zone = base::parse_integer(words[2].substr(0, words[2].size() - 1));
  constexpr std::int64_t kZones = 60, kNorth = 32600, kSouth = 32700;
  if (!zone || *zone < 1 || *zone > kZones || (side != 'N' && side != 'S')) throw bad();
  return "EPSG:" + std::to_string((side == 'N' ? kNorth : kSouth) + *zone);
}

ControlPoints read_control_points(const fs::path& path, const survey::Survey& survey,
                                  const ControlPointOptions& options) {
  if (!(options.image_scale > 0.0 && options.sigma_xy_m > 0.0 && options.sigma_z_m > 0.0))
    throw Error(ErrorCode::invalid_argument, "scale and sigmas of control points are not positive");
  ControlPoints result;
  result.crs = options.crs;
  const std::string ending = lower(path.extension().string());
  std::vector<Row> rows;
  if (ending == ".json") rows = rows_of_opensfm(base::read_file(path), path, result.crs);
  else if (ending == ".csv") rows = rows_of_csv(path, options, result.crs);
  else rows = rows_of_gcp_list(base::read_file(path), path, result.crs);

  const Placer placer(result.crs, survey, path);
  result.convention = (ending == ".json"  ? "OpenSfM ground control, normalised projections"
                       : ending == ".csv" ? "Table of control points, pixels in the corner convention"
                                          : "OpenDroneMap ground control, pixels from the first pixel's centre") +
                      std::string("; ") + result.crs + "; " + placer.how() + ".";
  std::map<std::string, const survey::Frame*, std::less<>> frames;
  for (const auto& frame : survey.frames)
    if (!frame.image.empty()) frames.emplace(fs::path(frame.image).filename().string(), &frame);

  std::map<std::string, survey::ControlPoint> points;
  std::map<std::string, Vec3> places;
  std::map<std::string, bool> refused;
  for (const auto& row : rows) {
    const std::string record = "control point " + row.name;
    if (refused.contains(row.name)) continue;
    if (!row.place || !std::isfinite(row.place->z())) {
      refused[row.name] = true;
      result.rejects.push_back({record, row.place ? "no_height" : "no_position",
                                row.place ? "the point has no height" : "the point has no surveyed position"});
      continue;
    }
    auto [it, is_new] = points.try_emplace(row.name);
    if (is_new) {
      it->second.name = row.name;
      try {
        it->second.p_world = placer.to_local(*row.place);
      } catch (Error& error) {
        error.default_file(path.string());
        error.in(row.record);
        throw;
      }
      places[row.name] = *row.place;
      it->second.sigma_xy_m = row.sigma_xy_m > 0.0 ? row.sigma_xy_m : options.sigma_xy_m;
      it->second.sigma_z_m = row.sigma_z_m > 0.0 ? row.sigma_z_m : options.sigma_z_m;
      it->second.check_only = row.check_only;
    } else if (places.at(row.name) != *row.place) {
      throw Error(ErrorCode::invalid_input, "two rows of one control point have different coordinates")
          .file(path.string())
          .record(row.record)
          .found("point '" + row.name + "'")
          .hint("Give every point its own name");
    }
    const auto frame = frames.find(fs::path(row.image).filename().string());
    if (frame == frames.end()) {
      result.rejects.push_back({record, "unknown_image", "the survey has no image " + row.image});
      continue;
    }
    const auto* camera = survey.camera(frame->second->camera);
    if (camera == nullptr) continue;
    const auto width = static_cast<double>(camera->width_px), height = static_cast<double>(camera->height_px);
    const Vec2 pixel = row.normalised ? opensfm_pixel(row.pixel, width, height) : Vec2(row.pixel * options.image_scale);
    if (!(pixel.x() >= 0.0 && pixel.y() >= 0.0 && pixel.x() <= width && pixel.y() <= height))
      throw Error(ErrorCode::invalid_input, "a control point is seen outside its image")
          .file(path.string())
          .record(row.record)
          .found(base::to_text(pixel.x()) + ", " + base::to_text(pixel.y()) + " px in " + row.image)
          .allowed("0.." + std::to_string(camera->width_px) + ", 0.." + std::to_string(camera->height_px))
          .hint("The file's pixels may be those of larger images: give --control-image-scale");
    auto& seen = it->second.observations;
    if (std::any_of(seen.begin(), seen.end(), [&](const auto& o) { return o.frame == frame->second->id; }))
      throw Error(ErrorCode::invalid_input, "a control point is seen twice in one image")
          .file(path.string())
          .record(row.record)
          .found("point '" + row.name + "' in " + row.image);
    seen.push_back({frame->second->id, pixel});
  }
  for (auto& [name, point] : points) {
    std::sort(point.observations.begin(), point.observations.end(),
              [](const auto& a, const auto& b) { return a.frame < b.frame; });
    result.points.push_back(std::move(point));
  }
  return result;
}

}  // namespace cairn::io
