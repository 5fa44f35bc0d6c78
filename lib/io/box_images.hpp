// The images that boxes belong to: found by name, for formats that give fractions of their size.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/detections.hpp"

namespace cairn::io::boxes {

// Regular files of a folder with this extension (".txt"), sorted by name. Throws not_found where there is none.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const std::filesystem::path& folder,
                                                          std::string_view extension);

// The image of a box file (its stem) or of an image path, with its size: looked for in `images`, at the path itself,
// beside it, and in the folder `images` beside `labels` (YOLO's layout). Throws not_found with the places looked at.
[[nodiscard]] BoxImage sized_image(const std::filesystem::path& path, const std::filesystem::path& images);

// Centre and size as fractions of the image to pixels.
[[nodiscard]] geometry::PixelBox from_fractions(const BoxImage& image, double x, double y, double width, double height);

}  // namespace cairn::io::boxes
