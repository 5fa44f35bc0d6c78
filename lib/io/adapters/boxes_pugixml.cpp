// Pascal VOC and CVAT XML 1.1. pugixml expands no entities and reads no DTD.
#include <algorithm>
#include <cmath>
#include <map>
#include <pugixml.hpp>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/box_images.hpp"
#include "io/box_readers.hpp"
#include "io/bytes.hpp"

namespace cairn::io::boxes {
namespace fs = std::filesystem;
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::uintmax_t kMaxBytes = std::uintmax_t{256} << 20U;

class XmlFile {
 public:
  explicit XmlFile(const fs::path& path) : path_(path), bytes_(checked(path)) {
    const auto result = document_.load_buffer(bytes_.text().data(), bytes_.text().size(), pugi::parse_default);
    if (!result) throw at(static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)), result.description());
  }
  [[nodiscard]] pugi::xml_node root() const { return document_.document_element(); }

  [[nodiscard]] Error error(const pugi::xml_node& node, const std::string& message) const {
    return at(static_cast<std::size_t>(std::max<std::ptrdiff_t>(node.offset_debug(), 0)), message);
  }
  [[nodiscard]] double number(const pugi::xml_node& node, const char* what, const char* text) const {
    const auto value = base::parse_real(text);
    if (!value || !std::isfinite(*value))
      throw error(node, std::string(what) + " is not a number").found("'" + std::string(text).substr(0, 60) + "'");
    return *value;
  }
  // Text of a child that must be there.
  [[nodiscard]] double child(const pugi::xml_node& node, const char* name) const {
    const pugi::xml_node found = node.child(name);
    if (!found) throw error(node, std::string("no <") + name + ">").allowed(std::string("<") + name + ">");
    return number(found, name, found.text().as_string());
  }
  [[nodiscard]] double attribute(const pugi::xml_node& node, const char* name) const {
    const auto found = node.attribute(name);
    if (!found) throw error(node, std::string("no attribute ") + name).found(std::string("<") + node.name() + ">");
    return number(node, name, found.value());
  }
  [[nodiscard]] std::int64_t whole(const pugi::xml_node& node, const char* name) const {
    const double value = attribute(node, name);
    if (value < 0.0 || value > 1e15 || value != std::floor(value))
      throw error(node, std::string(name) + " is not a whole number").found(base::to_text(value)).allowed("0 or more");
    return static_cast<std::int64_t>(value);
  }

 private:
  static const fs::path& checked(const fs::path& path) {
    std::error_code code;
    const auto bytes = fs::file_size(path, code);
    if (!code && bytes > kMaxBytes)
      throw Error(ErrorCode::invalid_input, "XML file is too large")
          .file(path.string())
          .found(std::to_string(bytes) + " bytes")
          .allowed("at most 256 MiB");
    return path;
  }
  [[nodiscard]] Error at(std::size_t offset, const std::string& message) const {
    const auto text = bytes_.text().substr(0, offset);
    return Error(ErrorCode::invalid_input, message)
        .file(path_.string())
        .record("line " + std::to_string(1 + std::count(text.begin(), text.end(), '\n')));
  }

  fs::path path_;
  FileBytes bytes_;
  pugi::xml_document document_;
};

std::int64_t size_of(const pugi::xml_node& node, const char* name) {
  const auto value = base::parse_integer(node.child(name).text().as_string());
  return value && *value > 0 ? *value : 0;
}

void read_voc_file(const fs::path& path, BoxFile& file) {
  const XmlFile xml(path);
  const auto root = xml.root();
  if (std::string_view(root.name()) != "annotation")
    throw xml.error(root, "not a Pascal VOC annotation")
        .found(std::string("<") + root.name() + ">")
        .allowed("<annotation>");
  BoxImage image;
  image.name = root.child("filename").text().as_string();
  if (image.name.empty()) image.name = path.stem().string();
  image.width_px = size_of(root.child("size"), "width");
  image.height_px = size_of(root.child("size"), "height");
  std::uint64_t number = 0;
  for (const auto& object : root.children("object")) {
    const auto sides = object.child("bndbox");
    if (!sides) throw xml.error(object, "object without a box").allowed("<bndbox>");
    ImageBox box;
    box.image = file.images.size();
    box.object_class = base::trim(object.child("name").text().as_string());
    if (box.object_class.empty()) throw xml.error(object, "object without a class").allowed("<name>");
    // Whole pixels from 1, both ends inside the box.
    box.box = {xml.child(sides, "xmin") - 1.0, xml.child(sides, "ymin") - 1.0, xml.child(sides, "xmax"),
               xml.child(sides, "ymax")};
    const auto score = object.child("score") ? object.child("score") : object.child("confidence");
    if (score) box.score = xml.number(score, "score", score.text().as_string());
    box.ignored = object.child("difficult").text().as_int(0) == 1;
    box.line = ++number;
    file.boxes.push_back(std::move(box));
  }
  file.images.push_back(std::move(image));
}

class CvatReader {
 public:
  CvatReader(const XmlFile& xml, BoxFile& file) : xml_(xml), file_(file) {}

  void read() {
    const auto root = xml_.root();
    if (std::string_view(root.name()) != "annotations")
      throw xml_.error(root, "not a CVAT file").found(std::string("<") + root.name() + ">").allowed("<annotations>");
    for (const auto& node : root.children("image")) read_image(node);
    const auto task =
        root.child("meta").child("task") ? root.child("meta").child("task") : root.child("meta").child("job");
    width_ = size_of(task.child("original_size"), "width");
    height_ = size_of(task.child("original_size"), "height");
    for (const auto& node : root.children("track")) read_track(node);
  }

 private:
  std::string label_of(const pugi::xml_node& node) const {
    const std::string label = node.attribute("label").value();
    if (label.empty()) throw xml_.error(node, "box without a label").allowed("label=\"...\"");
    return label;
  }
  void add(const pugi::xml_node& node, std::size_t image, const std::string& label, std::int64_t track) {
    ImageBox box;
    box.image = image;
    box.object_class = label;
    box.track = track;
    box.box = {xml_.attribute(node, "xtl"), xml_.attribute(node, "ytl"), xml_.attribute(node, "xbr"),
               xml_.attribute(node, "ybr")};
    box.line = ++number_;
    file_.boxes.push_back(std::move(box));
  }
  void read_image(const pugi::xml_node& node) {
    BoxImage image;
    image.number = xml_.whole(node, "id");
    image.name = node.attribute("name").value();
    image.width_px = node.attribute("width").as_llong(0);
    image.height_px = node.attribute("height").as_llong(0);
    if (!frames_.emplace(image.number, file_.images.size()).second)
      throw xml_.error(node, "image id appears twice").found(std::to_string(image.number));
    file_.images.push_back(image);
    for (const auto& box : node.children("box")) add(box, file_.images.size() - 1, label_of(box), -1);
  }
  void read_track(const pugi::xml_node& node) {
    const std::string label = label_of(node);
    const std::int64_t id = xml_.whole(node, "id");
    for (const auto& box : node.children("box")) {
      if (box.attribute("outside").as_int(0) == 1) continue;
      const std::int64_t frame = xml_.whole(box, "frame");
      const auto [at, fresh] = frames_.emplace(frame, file_.images.size());
      if (fresh) file_.images.push_back({frame, "", width_, height_});
      add(box, at->second, label, id);
    }
  }

  const XmlFile& xml_;
  BoxFile& file_;
  std::map<std::int64_t, std::size_t> frames_;
  std::int64_t width_ = 0, height_ = 0;
  std::uint64_t number_ = 0;
};

}  // namespace

BoxFile read_voc(const fs::path& path, const ReadBoxesOptions&) {
  BoxFile file;
  file.format = BoxFormat::voc;
  file.convention =
      "Pascal VOC pixels counted from 1, both ends inside the box: 1 was taken off xmin and ymin, xmax and ymax stay.";
  if (fs::is_directory(path)) {
    for (const auto& part : files_of(path, ".xml")) read_voc_file(part, file);
  } else {
    read_voc_file(path, file);
  }
  order_images(file);
  return file;
}

BoxFile read_cvat(const fs::path& path, const ReadBoxesOptions&) {
  BoxFile file;
  file.format = BoxFormat::cvat;
  file.convention = "CVAT corners xtl, ytl, xbr, ybr in pixels from the image's corner, taken as they are.";
  const XmlFile xml(path);
  CvatReader(xml, file).read();
  order_images(file);
  return file;
}

}  // namespace cairn::io::boxes
