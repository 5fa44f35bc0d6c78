#include <map>

#include "io/box_readers.hpp"
#include "io/csv.hpp"

namespace cairn::io::boxes {

BoxFile read_survey_csv(const std::filesystem::path& path, const ReadBoxesOptions&) {
  BoxFile file;
  file.format = BoxFormat::survey_csv;
  file.convention = "Boxes as xmin, ymin, xmax, ymax with the first pixel's centre at (0.5, 0.5) in the raw image.";
  CsvReader table(path);
  const auto image = table.column("image"), name = table.column("class"), xmin = table.column("xmin_px"),
             ymin = table.column("ymin_px"), xmax = table.column("xmax_px"), ymax = table.column("ymax_px"),
             score = table.column("score");
  std::map<std::string, std::size_t, std::less<>> images;
  while (table.next()) {
    ImageBox box;
    const auto text = table.required(image);
    auto at = images.find(text);
    if (at == images.end()) {
      at = images.emplace(std::string(text), file.images.size()).first;
      file.images.push_back({-1, std::string(text), 0, 0});
    }
    box.image = at->second;
    box.object_class = table.required(name);
    box.score = table.real(score);
    box.box = {table.real(xmin), table.real(ymin), table.real(xmax), table.real(ymax)};
    box.line = table.line();
    file.boxes.push_back(std::move(box));
  }
  order_images(file);
  return file;
}

}  // namespace cairn::io::boxes
