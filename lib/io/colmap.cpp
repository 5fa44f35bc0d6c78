#include "io/colmap.hpp"

#include "base/atomic_file.hpp"
#include "base/error.hpp"

namespace cairn::io {
namespace fs = std::filesystem;

ColmapModel read_colmap(const fs::path& folder) {
  std::error_code code;
  const auto has = [&](const char* name) { return fs::is_regular_file(folder / name, code); };
  const bool binary = has("cameras.bin") && has("images.bin");
  const bool text = has("cameras.txt") && has("images.txt");
  if (!binary && !text)
    throw base::Error(base::ErrorCode::not_found, "no COLMAP model in this folder")
        .file(folder.string())
        .allowed("cameras.bin and images.bin, or cameras.txt and images.txt")
        .hint("Name the folder that holds the model, often sparse/0");
  const std::string suffix = binary ? ".bin" : ".txt";
  const std::string cameras = base::read_file(folder / ("cameras" + suffix)),
                    images = base::read_file(folder / ("images" + suffix));
  const bool has_points = has(("points3D" + suffix).c_str());
  const std::string points = has_points ? base::read_file(folder / ("points3D" + suffix)) : std::string();
  const ColmapFiles files{cameras, images, has_points ? std::string_view(points) : std::string_view(), folder};
  ColmapModel model = binary ? parse_colmap_binary(files) : parse_colmap_text(files);
  if (binary && text) model.notes.emplace_back("The folder holds a binary and a text model; the binary one was read.");
  if (!has_points) model.notes.emplace_back("The model has no points3D file, so there are no tie points.");
  if (has(("rigs" + suffix).c_str()) || has(("frames" + suffix).c_str()))
    model.notes.emplace_back("The files of rigs and frames were not read; each image keeps its own pose.");
  return model;
}

}  // namespace cairn::io
