#include <charconv>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/colmap_model.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

// Lines of a text file, with their numbers.
class Lines {
 public:
  Lines(std::string_view text, std::string file) : rest_(text), file_(std::move(file)) {}

  // The next line, empty or not, without its end.
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const auto end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++number_;
    return true;
  }
  // The next line that is neither blank nor a comment.
  bool next_record(std::string_view& line) {
    while (next(line)) {
      const auto text = base::trim(line);
      if (!text.empty() && text.front() != '#') return true;
    }
    return false;
  }
  [[nodiscard]] const std::string& file() const { return file_; }
  [[nodiscard]] std::string record() const { return "line " + std::to_string(number_); }

  // Gives an error thrown while the line was read its place.
  [[noreturn]] void place(Error& error) const { throw std::move(error).file(file_).record(record()); }

 private:
  std::string_view rest_;
  std::string file_;
  std::uint64_t number_ = 0;
};

// Blank-separated words of a line.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}

  bool next(std::string_view& word) {
    skip_blanks();
    if (rest_.empty()) return false;
    word = rest_.substr(0, rest_.find_first_of(" \t"));
    rest_.remove_prefix(word.size());
    return true;
  }
  [[nodiscard]] bool at_end() {
    skip_blanks();
    return rest_.empty();
  }
  // All that is left, for names with blanks.
  [[nodiscard]] std::string_view rest() const { return base::trim(rest_); }

  double real(std::string_view what) { return number<double>(what, "a number"); }
  std::int64_t integer(std::string_view what) { return number<std::int64_t>(what, "a whole number"); }
  std::int64_t id(std::string_view what) {
    const std::int64_t value = integer(what);
    if (value < 0)
      throw Error(ErrorCode::invalid_input, std::string(what) + " is negative")
          .found(std::to_string(value))
          .allowed("0 or more");
    return value;
  }

 private:
  void skip_blanks() {
    const auto first = rest_.find_first_not_of(" \t");
    rest_.remove_prefix(first == std::string_view::npos ? rest_.size() : first);
  }
  template <typename T>
  T number(std::string_view what, std::string_view allowed) {
    std::string_view word;
    if (!next(word)) throw Error(ErrorCode::invalid_input, "line ends before " + std::string(what)).allowed(allowed);
    T value{};
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code != std::errc{} || end != word.data() + word.size())
      throw Error(ErrorCode::invalid_input, std::string(what) + " is not " + std::string(allowed))
          .found("'" + std::string(word.substr(0, 60)) + "'")
          .allowed(allowed);
    return value;
  }

  std::string_view rest_;
};

double finite(double value, std::string_view what) {
  if (!std::isfinite(value))
    throw Error(ErrorCode::invalid_input, std::string(what) + " is not finite").found(base::to_text(value));
  return value;
}

survey::Camera camera_of(std::string_view line) {
  Words words(line);
  const std::int64_t id = words.id("camera id");
  std::string_view name;
  if (!words.next(name)) throw Error(ErrorCode::invalid_input, "line ends before the camera model");
  const ColmapCameraModel* model = find_colmap_model(name);
  if (model == nullptr)
    throw Error(ErrorCode::invalid_input, "unknown camera model")
        .found("'" + std::string(name.substr(0, 60)) + "'")
        .allowed("a model of COLMAP");
  require_supported(*model);
  const double width = words.real("width"), height = words.real("height");
  std::vector<double> parameters;
  while (!words.at_end() && parameters.size() <= model->parameters)
    parameters.push_back(words.real("camera parameter"));
  return make_colmap_camera(id, *model, width, height, parameters);
}

ColmapImage image_of(std::string_view line) {
  Words words(line);
  ColmapImage image;
  image.id = words.id("image id");
  std::array<double, 7> pose{};
  for (auto& value : pose) value = words.real("pose");
  image.T_world_camera = invert_colmap_pose(pose);
  image.camera = words.id("camera id");
  image.name = words.rest();
  if (image.name.empty()) throw Error(ErrorCode::invalid_input, "image without a name");
  return image;
}

std::vector<ColmapObservation> observations_of(std::string_view line) {
  std::vector<ColmapObservation> out;
  Words words(line);
  for (std::int64_t index = 0; !words.at_end(); ++index) {
    const double x = finite(words.real("key point x"), "key point"), y = finite(words.real("key point y"), "key point");
    const std::int64_t point = words.integer("3-D point id");
    if (point >= 0) out.push_back({index, point, {x, y}});
  }
  return out;
}

ColmapPoint point_of(std::string_view line, std::vector<ColmapTrackElement>& tracks) {
  Words words(line);
  ColmapPoint point;
  point.id = words.id("point id");
  for (int i = 0; i < 3; ++i) point.position[i] = finite(words.real("point coordinate"), "point coordinate");
  for (auto& channel : point.rgb) {
    const std::int64_t value = words.integer("colour");
    if (value < 0 || value > 255)
      throw Error(ErrorCode::invalid_input, "colour out of range").found(std::to_string(value)).allowed("0 to 255");
    channel = static_cast<std::uint8_t>(value);
  }
  point.error_px = finite(words.real("reprojection error"), "reprojection error");
  while (!words.at_end()) {
    const std::int64_t image = words.id("image id of the track");
    tracks.push_back({point.id, image, words.id("key point index of the track")});
  }
  return point;
}

}  // namespace

ColmapModel parse_colmap_text(const ColmapFiles& files) {
  ColmapModel model;
  const std::string cameras_file = (files.folder / "cameras.txt").string(),
                    images_file = (files.folder / "images.txt").string(),
                    points_file = (files.folder / "points3D.txt").string();
  std::string_view line;
  Lines cameras(files.cameras, cameras_file);
  while (cameras.next_record(line)) try {
      model.cameras.push_back(camera_of(line));
    } catch (Error& error) {
      cameras.place(error);
    }
  Lines images(files.images, images_file);
  while (images.next_record(line)) try {
      ColmapImage image = image_of(line);
      // The second line holds the key points; it is empty where there are none, and may be missing at the end.
      if (images.next(line)) image.observations = observations_of(line);
      model.images.push_back(std::move(image));
    } catch (Error& error) {
      images.place(error);
    }
  std::vector<ColmapTrackElement> tracks;
  Lines points(files.points, points_file);
  while (points.next_record(line)) try {
      model.points.push_back(point_of(line, tracks));
    } catch (Error& error) {
      points.place(error);
    }
  finish_colmap_model(model, tracks, images_file, points_file);
  return model;
}

}  // namespace cairn::io
