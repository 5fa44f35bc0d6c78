#include <cmath>
#include <map>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/box_images.hpp"
#include "io/box_readers.hpp"
#include "io/bytes.hpp"
#include "io/json.hpp"

namespace cairn::io::boxes {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

Error in_element(const Error& e, const fs::path& path, const std::string& element) {
  return std::move(Error(e.code(), e.message()).file(e.file().empty() ? path.string() : e.file()).record(element))
      .found(e.found())
      .allowed(e.allowed())
      .hint(e.hint());
}

ImageBox box_of(const Json& object, const BoxImage& image) {
  const Json& at = object.at("relative_coordinates");
  ImageBox box;
  if (const Json* name = object.find("name")) box.object_class = name->as_string();
  else box.object_class = std::to_string(object.at("class_id").as_integer());
  box.score = object.at("confidence").as_real();
  box.box = from_fractions(image, at.at("center_x").as_real(), at.at("center_y").as_real(), at.at("width").as_real(),
                           at.at("height").as_real());
  return box;
}

// The number behind `key`, which must stand in the text.
double value_behind(std::string_view text, std::string_view key, const TextReader& reader) {
  const auto at = text.find(key);
  std::string_view rest = at == std::string_view::npos ? std::string_view() : text.substr(at + key.size());
  std::string_view word = take_word(rest);
  if (word.ends_with(')')) word.remove_suffix(1);
  const auto value = parse_number(word);
  if (!value)
    throw reader.error("not a box of darknet's -ext_output")
        .found("'" + std::string(text.substr(0, 80)) + "'")
        .allowed("name: 92% (left_x: 118 top_y: 124 width: 452 height: 309)");
  return *value;
}

}  // namespace

BoxFile read_darknet_json(const fs::path& path, const ReadBoxesOptions& options) {
  BoxFile file;
  file.format = BoxFormat::darknet_json;
  file.convention = "darknet centre and size as fractions of the image file's width and height.";
  const Json json = read_json(path);
  std::uint64_t number = 0;
  std::size_t i = 0;
  for (const Json& frame : json.as_array()) {
    const std::string element = "element [" + std::to_string(i++) + "]";
    try {
      BoxImage image;
      const fs::path name = frame.at("filename").as_string();
      const auto& objects = frame.at("objects").as_array();
      if (!objects.empty()) {
        const fs::path beside = name.is_absolute() ? name : path.parent_path() / name;
        image = sized_image(beside, options.images);
      }
      image.name = name.filename().string();
      image.number = frame.at("frame_id").as_integer();
      for (const Json& object : objects) {
        ImageBox box = box_of(object, image);
        box.image = file.images.size();
        box.line = ++number;
        file.boxes.push_back(std::move(box));
      }
      file.images.push_back(std::move(image));
    } catch (const Error& e) {
      throw in_element(e, path, element);
    }
  }
  order_images(file);
  return file;
}

BoxFile read_darknet_txt(const fs::path& path, const ReadBoxesOptions&) {
  BoxFile file;
  file.format = BoxFormat::darknet_txt;
  file.convention = "darknet left, top, width and height in pixels from the image's corner, rounded to whole ones.";
  const FileBytes bytes(path);
  TextReader reader(bytes.text(), bytes.name());
  std::map<std::string, std::size_t> seen;
  while (const auto line = reader.next_line()) {
    std::string_view text = base::trim(*line);
    // "Enter Image Path: data/dog.jpg: Predicted in 29.7 milli-seconds."
    if (const auto predicted = text.find(": Predicted in "); predicted != std::string_view::npos) {
      std::string_view name = text.substr(0, predicted);
      if (const auto prompt = name.rfind("Path: "); prompt != std::string_view::npos) name.remove_prefix(prompt + 6);
      const std::string image = fs::path(std::string(base::trim(name))).filename().string();
      if (!seen.emplace(image, file.images.size()).second) throw reader.error("image appears twice").found(image);
      file.images.push_back({-1, image, 0, 0});
      continue;
    }
    const auto sides = text.find("(left_x:");
    if (sides == std::string_view::npos) continue;
    if (file.images.empty())
      throw reader.error("box before the line that names its image").allowed("a line 'IMAGE: Predicted in ...' first");
    const auto colon = text.substr(0, sides).rfind(':');
    const auto percent = text.substr(0, sides).find('%', colon == std::string_view::npos ? 0 : colon);
    if (colon == std::string_view::npos || percent == std::string_view::npos)
      throw reader.error("box without a class and a score").allowed("name: 92% (left_x: ...");
    const auto score = parse_number(base::trim(text.substr(colon + 1, percent - colon - 1)));
    if (!score) throw reader.error("score is not a number").found(std::string(text.substr(0, sides)));
    ImageBox box;
    box.image = file.images.size() - 1;
    box.object_class = text.substr(0, colon);
    box.score = *score / 100.0;
    const double left = value_behind(text, "left_x:", reader), top = value_behind(text, "top_y:", reader);
    box.box = {left, top, left + value_behind(text, "width:", reader), top + value_behind(text, "height:", reader)};
    box.line = reader.line();
    file.boxes.push_back(std::move(box));
  }
  order_images(file);
  return file;
}

}  // namespace cairn::io::boxes
