#include "io/box_images.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "io/image.hpp"

namespace cairn::io::boxes {
namespace fs = std::filesystem;

std::vector<fs::path> files_of(const fs::path& folder, std::string_view extension) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().extension() == extension) files.push_back(entry.path());
  if (files.empty())
    throw base::Error(base::ErrorCode::not_found, "no files of boxes in the folder")
        .file(folder.string())
        .allowed("files " + std::string(extension));
  std::sort(files.begin(), files.end());
  return files;
}

BoxImage sized_image(const fs::path& path, const fs::path& images) {
  std::vector<fs::path> folders;
  if (!images.empty()) folders.push_back(images);
  folders.push_back(path.parent_path());
  if (path.parent_path().filename() == "labels") folders.push_back(path.parent_path().parent_path() / "images");
  std::error_code code;
  for (const auto& folder : folders)
    for (const auto* extension : {".jpg", ".JPG", ".jpeg", ".JPEG", ".png", ".PNG"}) {
      fs::path candidate = folder / path.stem();
      candidate += extension;
      if (!fs::is_regular_file(candidate, code)) continue;
      const ImageHeader header = read_image_header(candidate);
      return {-1, candidate.filename().string(), header.width_px, header.height_px};
    }
  std::string looked;
  for (const auto& folder : folders) looked += (looked.empty() ? "" : ", ") + folder.string();
  throw base::Error(base::ErrorCode::not_found, "image not found: fractions need its size")
      .file(path.string())
      .found("no " + path.stem().string() + ".jpg or .png in " + looked)
      .hint("Name the folder of the images with --images");
}

geometry::PixelBox from_fractions(const BoxImage& image, double x, double y, double width, double height) {
  const auto w = static_cast<double>(image.width_px), h = static_cast<double>(image.height_px);
  return {(x - 0.5 * width) * w, (y - 0.5 * height) * h, (x + 0.5 * width) * w, (y + 0.5 * height) * h};
}

}  // namespace cairn::io::boxes
