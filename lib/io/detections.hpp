// Boxes of detectors and annotators, in the formats they come in, as one neutral record.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/primitives.hpp"

namespace cairn::io {

// mot: MOTChallenge det.txt, gt.txt and results; coco: results (a list) or ground truth (an object); yolo: one .txt an
// image, normalised; voc: one .xml an image; cvat: XML 1.1, images or video; darknet_json, darknet_txt: what
// `darknet detector test` writes; survey_csv: image,class,xmin_px,ymin_px,xmax_px,ymax_px,score.
enum class BoxFormat { mot, coco, yolo, voc, cvat, darknet_json, darknet_txt, survey_csv };

[[nodiscard]] std::string_view name_of(BoxFormat format);
// Names of all formats, as --format takes them.
[[nodiscard]] const std::vector<std::string>& box_format_names();
// Throws invalid_argument with the known names.
[[nodiscard]] BoxFormat box_format_from(std::string_view name);

// An image that the file names. number: the file's own frame number or image id; -1 where it has none. Sizes 0 where
// the file does not tell. image: "" in formats that number frames only.
struct BoxImage {
  std::int64_t number = -1;
  std::string name;
  std::int64_t width_px = 0, height_px = 0;

  friend bool operator==(const BoxImage&, const BoxImage&) = default;
};

struct ImageBox {
  std::size_t image = 0;  // index into BoxFile::images
  std::string object_class;
  double score = 1.0;  // as in the file: detectors differ in scale; 1 where the file has none
  geometry::PixelBox
      box;  // px; may be empty, reversed or not finite: the file's own fault is kept for its user to name
  std::int64_t track = -1;  // identity the file gives; -1 = none
  bool ignored = false;     // the file says that the box does not count: MOT gt flag 0, COCO iscrowd
  std::uint64_t line = 0;   // of the file, or the number of the record, from 1

  friend bool operator==(const ImageBox&, const ImageBox&) = default;
};

struct BoxFile {
  BoxFormat format = BoxFormat::mot;
  std::string convention;        // one sentence: which convention of pixels was read, how it was converted
  std::vector<BoxImage> images;  // in the order of their numbers, else of their names (digits by value)
  std::vector<ImageBox> boxes;   // in the order of the file
  bool unsorted = false;         // mot: frame numbers do not ascend
};

struct ReadBoxesOptions {
  std::vector<std::string> class_names;  // of class numbers 0, 1, 2 (yolo); empty = the numbers themselves
  std::filesystem::path images;          // folder of the images (yolo: their sizes); "" = beside the boxes
  bool as_in_file = false;               // mot: leave the pixels as they stand, for reading and writing alike
};

// What kind of boxes a file or folder holds, from its content. Throws not_found, or invalid_input where it is none of
// those above.
[[nodiscard]] BoxFormat recognise_boxes(const std::filesystem::path& path);

// Reads a file, or a folder of one file an image (yolo, voc). Pixels come out in the corner convention (the first
// pixel spans 0..1) unless as_in_file. Throws invalid_input with file, line or record, value and what is allowed: a
// number that cannot be read, a frame number that is not whole, an image without size (yolo), an unknown category.
// Cost linear in bytes.
[[nodiscard]] BoxFile read_boxes(const std::filesystem::path& path, BoxFormat format,
                                 const ReadBoxesOptions& options = {});

// The lines of a class name list (darknet's .names): one name a line, blank ones at the end left out.
[[nodiscard]] std::vector<std::string> read_class_names(const std::filesystem::path& path);

// One row of a MOTChallenge result: frame,id,left,top,width,height,score,-1,-1,-1.
struct MotRow {
  std::int64_t frame = 0, track = 0;
  geometry::PixelBox box;
  double score = 1.0;
};
// Pixels to two decimals as the reference tracker writes them, scores in shortest form. Throws internal where a value
// is not finite, resource_exhausted where a write fails.
void write_mot(const std::filesystem::path& path, std::span<const MotRow> rows);

}  // namespace cairn::io
