// Parts of photographs, encoded for a page.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/primitives.hpp"

namespace cairn::io {

struct ImageCropOptions {
  double margin = 0.6;             // around the box, in its longer side
  std::int64_t min_side_px = 48;   // of the part taken from the photograph
  std::int64_t max_side_px = 224;  // of the result; larger parts are reduced
  std::int64_t quality = 82;       // of the JPEG, 1..100
  bool outline = true;             // draws the box
};

// A square about each box as a JPEG file in memory, in the order of the boxes. Boxes are in pixels of the raw raster,
// corner convention; the EXIF orientation is not applied. A square that passes the border is moved inside.
// An entry is empty where the box lies outside the photograph. The photograph is decoded once.
// Throws not_found, or invalid_input where it cannot be decoded; above 400 Mpx it is refused.
[[nodiscard]] std::vector<std::string> crop_jpegs(const std::filesystem::path& photograph,
                                                  const std::vector<geometry::PixelBox>& boxes,
                                                  const ImageCropOptions& options = {});

// A part with its place: pixel (x, y) of the raster lies at ((x - x_px) scale, (y - y_px) scale) of the picture.
struct ImagePart {
  std::string jpeg;  // empty where the box lies outside the photograph
  double x_px = 0.0, y_px = 0.0, scale = 1.0;
  double side_px = 0.0;  // of the picture, square
};

// As crop_jpegs, with the place of each part.
[[nodiscard]] std::vector<ImagePart> crop_parts(const std::filesystem::path& photograph,
                                                const std::vector<geometry::PixelBox>& boxes,
                                                const ImageCropOptions& options = {});

}  // namespace cairn::io
