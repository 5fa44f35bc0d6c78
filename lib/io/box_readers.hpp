// The readers behind read_boxes, one a format.
#pragma once

#include "io/detections.hpp"

namespace cairn::io::boxes {

[[nodiscard]] BoxFile read_mot(const std::filesystem::path& path, const ReadBoxesOptions& options);
[[nodiscard]] BoxFile read_coco(const std::filesystem::path& path, const ReadBoxesOptions& options);
[[nodiscard]] BoxFile read_yolo(const std::filesystem::path& path, const ReadBoxesOptions& options);
[[nodiscard]] BoxFile read_voc(const std::filesystem::path& path, const ReadBoxesOptions& options);
[[nodiscard]] BoxFile read_cvat(const std::filesystem::path& path, const ReadBoxesOptions& options);
[[nodiscard]] BoxFile read_darknet_json(const std::filesystem::path& path, const ReadBoxesOptions& options);
[[nodiscard]] BoxFile read_darknet_txt(const std::filesystem::path& path, const ReadBoxesOptions& options);
[[nodiscard]] BoxFile read_survey_csv(const std::filesystem::path& path, const ReadBoxesOptions& options);

// Makes `file.images` ascend by number, where all have one, else by name with digits compared by value (img2 < img10),
// and lets the boxes follow. Images must be distinct.
void order_images(BoxFile& file);

}  // namespace cairn::io::boxes
