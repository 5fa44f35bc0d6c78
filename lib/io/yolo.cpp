#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

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

constexpr double kMostNormalised = 1.5;  // a box may reach over the border; beyond this it is in pixels

bool class_list(const fs::path& path) {
  const std::string name = path.filename().string();
  return name == "classes.txt" || name == "labels.txt" || name == "train.txt" || name == "val.txt" ||
         name == "test.txt";
}

std::vector<std::string> names_beside(const fs::path& folder) {
  for (const auto* name : {"classes.txt", "obj.names", "../classes.txt", "../obj.names"}) {
    std::error_code code;
    if (fs::is_regular_file(folder / name, code)) return read_class_names(folder / name);
  }
  return {};
}

void read_one(const fs::path& path, const ReadBoxesOptions& options, const std::vector<std::string>& names,
              BoxFile& file) {
  const FileBytes bytes(path);
  TextReader reader(bytes.text(), bytes.name());
  BoxImage image;
  std::array<double, 7> v{};
  while (const auto line = reader.next_line()) {
    std::string_view rest = *line;
    std::size_t count = 0;
    for (auto word = take_word(rest); !word.empty(); word = take_word(rest)) {
      const auto value = parse_number(word);
      if (!value)
        throw reader.error("not a number")
            .found("'" + std::string(word.substr(0, 60)) + "'")
            .allowed("class x_centre y_centre width height [score]");
      if (count < v.size()) v[count] = *value;
      ++count;
    }
    if (count == 0) continue;
    if (count < 5 || count > 6)
      throw reader.error("not a YOLO box")
          .found(std::to_string(count) + " numbers")
          .allowed("5 or 6: class x_centre y_centre width height [score]")
          .hint(count > 6 ? "Outlines (segmentation labels) are not boxes: export boxes" : "Check the file");
    for (std::size_t i = 1; i < 5; ++i)
      if (std::abs(v[i]) > kMostNormalised)
        throw reader.error("box is not normalised")
            .found(base::to_text(v[i]))
            .allowed("fractions of the image's width and height, 0 to 1");
    if (v[0] < 0.0 || v[0] != std::floor(v[0]) || v[0] > 1e6)
      throw reader.error("class is not a whole number").found(base::to_text(v[0])).allowed("0, 1, 2");
    if (image.name.empty()) image = sized_image(path, options.images);
    ImageBox box;
    box.image = file.images.size();
    const auto number = static_cast<std::size_t>(v[0]);
    if (!names.empty() && number >= names.size())
      throw reader.error("class number without a name")
          .found(std::to_string(number))
          .allowed("0 to " + std::to_string(names.size() - 1));
    box.object_class = names.empty() ? std::to_string(number) : names[number];
    box.box = from_fractions(image, v[1], v[2], v[3], v[4]);
    if (count == 6) box.score = v[5];
    box.line = reader.line();
    file.boxes.push_back(std::move(box));
  }
  // An empty file says that its image shows nothing; the image need not be there.
  if (image.name.empty()) image.name = path.stem().string();
  file.images.push_back(std::move(image));
}

}  // namespace

BoxFile read_yolo(const fs::path& path, const ReadBoxesOptions& options) {
  BoxFile file;
  file.format = BoxFormat::yolo;
  file.convention =
      "YOLO centre and size as fractions of the image file's width and height (not of a letterboxed copy), the image "
      "not rotated.";
  std::vector<fs::path> parts{path};
  const bool folder = fs::is_directory(path);
  if (folder) {
    parts = files_of(path, ".txt");
    std::erase_if(parts, class_list);
  }
  const auto names =
      options.class_names.empty() ? names_beside(folder ? path : path.parent_path()) : options.class_names;
  for (const auto& part : parts) read_one(part, options, names, file);
  order_images(file);
  return file;
}

}  // namespace cairn::io::boxes
