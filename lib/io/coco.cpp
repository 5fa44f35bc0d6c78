#include <map>
#include <unordered_map>

#include "base/error.hpp"
#include "io/box_readers.hpp"
#include "io/json.hpp"

namespace cairn::io::boxes {
namespace {

using base::Error;
using base::ErrorCode;

class CocoReader {
 public:
  CocoReader(const std::filesystem::path& path, const ReadBoxesOptions& options) : path_(path), options_(options) {}

  BoxFile read() {
    file_.format = BoxFormat::coco;
    file_.convention = "COCO boxes [left, top, width, height] in pixels from the image's corner, taken as they are.";
    const Json json = read_json(path_);
    if (json.is_array()) {
      read_list(json, "results");
    } else {
      read_images(json.at("images"));
      read_categories(json.at("categories"));
      read_list(json.at("annotations"), "annotations");
    }
    order_images(file_);
    return std::move(file_);
  }

 private:
  // Runs `body` for each element; errors name the file and the element.
  template <typename Body>
  void each(const Json& list, const char* name, Body&& body) {
    std::uint64_t number = 0;
    for (const Json& item : list.as_array()) {
      try {
        body(item, ++number);
      } catch (const Error& e) {
        auto named = Error(e.code(), e.message())
                         .file(path_.string())
                         .record(std::string(name) + "[" + std::to_string(number - 1) + "]");
        throw std::move(named).found(e.found()).allowed(e.allowed()).hint(e.hint());
      }
    }
  }

  void read_images(const Json& list) {
    each(list, "images", [&](const Json& item, std::uint64_t) {
      BoxImage image;
      image.number = item.at("id").as_integer();
      image.name = item.at("file_name").as_string();
      if (const Json* width = item.find("width")) image.width_px = width->as_integer();
      if (const Json* height = item.find("height")) image.height_px = height->as_integer();
      if (!by_number_.emplace(image.number, file_.images.size()).second)
        throw Error(ErrorCode::invalid_input, "image id appears twice").found(std::to_string(image.number));
      file_.images.push_back(std::move(image));
    });
    closed_ = true;
  }

  void read_categories(const Json& list) {
    each(list, "categories", [&](const Json& item, std::uint64_t) {
      const std::int64_t id = item.at("id").as_integer();
      if (!categories_.emplace(id, item.at("name").as_string()).second)
        throw Error(ErrorCode::invalid_input, "category id appears twice").found(std::to_string(id));
    });
  }

  std::size_t image_of(const Json& id) {
    if (id.is_string()) {
      const auto [at, fresh] = by_name_.emplace(id.as_string(), file_.images.size());
      if (fresh) file_.images.push_back({-1, id.as_string(), 0, 0});
      return at->second;
    }
    const auto at = by_number_.find(id.as_integer());
    if (at != by_number_.end()) return at->second;
    if (closed_)
      throw Error(ErrorCode::invalid_input, "box of an unknown image")
          .found("image_id " + std::to_string(id.as_integer()))
          .allowed("one of the " + std::to_string(file_.images.size()) + " ids of images[]");
    by_number_.emplace(id.as_integer(), file_.images.size());
    file_.images.push_back({id.as_integer(), "", 0, 0});
    return file_.images.size() - 1;
  }

  std::string class_of(std::int64_t id) {
    if (!categories_.empty()) {
      const auto at = categories_.find(id);
      if (at == categories_.end())
        throw Error(ErrorCode::invalid_input, "box of an unknown category")
            .found("category_id " + std::to_string(id))
            .allowed("an id of categories[]");
      return at->second;
    }
    if (options_.class_names.empty()) return std::to_string(id);
    if (id < 0 || static_cast<std::size_t>(id) >= options_.class_names.size())
      throw Error(ErrorCode::invalid_input, "class number without a name")
          .found("category_id " + std::to_string(id))
          .allowed("0 to " + std::to_string(options_.class_names.size() - 1));
    return options_.class_names[static_cast<std::size_t>(id)];
  }

  void read_list(const Json& list, const char* name) {
    each(list, name, [&](const Json& item, std::uint64_t number) {
      const Json* sides = item.find("bbox");
      if (sides == nullptr || !sides->is_array() || sides->size() != 4)
        throw Error(ErrorCode::invalid_input, "no bbox of four numbers")
            .found(sides == nullptr ? "no member bbox" : sides->dump(0).substr(0, 60))
            .allowed("bbox: [left, top, width, height]");
      const auto& s = sides->as_array();
      ImageBox box;
      box.image = image_of(item.at("image_id"));
      box.object_class = class_of(item.at("category_id").as_integer());
      const double left = s[0].as_real(), top = s[1].as_real();
      box.box = {left, top, left + s[2].as_real(), top + s[3].as_real()};
      if (const Json* score = item.find("score")) box.score = score->as_real();
      if (const Json* track = item.find("track_id"); track != nullptr && track->is_integer())
        box.track = track->as_integer();
      if (const Json* crowd = item.find("iscrowd"); crowd != nullptr && !crowd->is_null())
        box.ignored = crowd->is_bool() ? crowd->as_bool() : crowd->as_integer() != 0;
      box.line = number;
      file_.boxes.push_back(std::move(box));
    });
  }

  const std::filesystem::path& path_;
  const ReadBoxesOptions& options_;
  BoxFile file_;
  std::unordered_map<std::int64_t, std::size_t> by_number_;
  std::unordered_map<std::string, std::size_t> by_name_;
  std::map<std::int64_t, std::string> categories_;
  bool closed_ = false;  // the file lists its images
};

}  // namespace

BoxFile read_coco(const std::filesystem::path& path, const ReadBoxesOptions& options) {
  return CocoReader(path, options).read();
}

}  // namespace cairn::io::boxes
