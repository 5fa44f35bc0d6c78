// What all importers share: the options, and what is attached to the frames they found.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/reject.hpp"
#include "base/run_context.hpp"
#include "pipeline/outcome.hpp"
#include "survey/survey.hpp"

namespace cairn::pipeline {

struct ImportInputs {
  std::filesystem::path survey_folder;  // its final name: file references are relative to it
  std::string name;                     // of the survey; "" = the folder's name
  std::optional<geometry::Geodetic> origin;
  std::optional<survey::HeightType> height_type;  // of the origin's height
  std::filesystem::path detections;               // table of boxes; "" = none
  std::string detections_format = "auto";         // of io::box_format_names(); auto = recognised
  std::filesystem::path detections_names;         // class names of formats that number them; "" = none
  std::optional<double> detections_scale;         // box pixels * scale = image file pixels; default by importer
  std::filesystem::path cloud;                    // LAS; "" = none
  std::filesystem::path similarity;               // JSON; "" = the cloud shares the poses' frame
  std::string cloud_crs;                          // overrides what the cloud declares; "local" = the survey's ENU
  survey::HeightType cloud_height_type = survey::HeightType::unknown;
  bool copy_images = false;  // into the survey folder, instead of a reference
  bool strict = false;       // an assumed convention is an error
};

// A survey in the making. image_names[i] is the name frame i had in its source ("DJI_0018.JPG").
struct Imported {
  survey::Survey survey;
  std::vector<std::string> image_names;
  std::vector<std::filesystem::path> image_files;  // empty path = the frame has no image
  std::vector<base::Reject> rejects;
};

// "LAT,LON,HEIGHT" in degrees and metres. Throws invalid_argument for another shape, crs_mismatch for a
// position off the globe.
[[nodiscard]] geometry::Geodetic parse_origin(std::string_view text);

// "MODEL,WIDTH,HEIGHT,PARAMETERS" in COLMAP's models and order, for the image files' pixels, for example
// "PINHOLE,1600,900,914.3,914.3,800,450". Throws invalid_argument.
[[nodiscard]] survey::Camera parse_camera(const std::string& text);

// Frame ids that people recognise: the number at the end of each image's stem (DJI_0018 -> 18) where
// every image has one and no two share it, else 1, 2, 3 in the order of the names.
[[nodiscard]] std::vector<survey::FrameId> frame_ids_for(const std::vector<std::string>& image_names);

// Photographs (.jpg, .jpeg, .png, any case) directly in a folder, sorted by name. Throws not_found where
// the folder is missing or has none.
[[nodiscard]] std::vector<std::filesystem::path> list_images(const std::filesystem::path& folder);

// Reads boxes: columns image, class, xmin_px, ymin_px, xmax_px, ymax_px, score (others are not read).
// Joined by the whole image name, or by its last part where that is unique. Ids 1, 2, 3 in file order;
// pixels times `scale`. Throws invalid_input for an image that no frame has, a box with max < min, a
// score outside 0..1, a number that is not finite.
void attach_detections(Imported& imported, const std::filesystem::path& table, double scale,
                       const std::filesystem::path& survey_folder);

// The same for boxes of every other format (io/detections.hpp), joined by the image's name, its last part, or that part
// without extension; where a file has frame numbers only, by their order (mot from 1, cvat from 0) or as frame ids.
// Boxes that the file marks as not counting are left out, with a note.
void attach_boxes(Imported& imported, const ImportInputs& in, double scale);

// Similarity of a cloud as T_world_source. Accepted: {"scale", "rotation"|"quaternion", "translation_m",
// "direction": "world_to_source" | "source_to_world"}, or a file whose member colmap_enu_to_cloud_enu
// holds scale, rotation, translation_m (X_cloud = s R X + t). Where the file names an origin, it must
// be the survey's (crs_mismatch).
[[nodiscard]] geometry::Similarity read_similarity(const std::filesystem::path& path, const survey::Origin& origin);

// Declares the cloud as a source. Its CRS is the given one, else what the file declares; without
// either: crs_mismatch.
void attach_cloud(Imported& imported, const ImportInputs& in);

// Attaches detections and cloud, checks --strict, copies images where asked, and writes the survey into
// `out`, an existing staged folder.
[[nodiscard]] Outcome finish_import(Imported imported, const ImportInputs& in, double default_detections_scale,
                                    const std::filesystem::path& out, base::RunContext& ctx);

}  // namespace cairn::pipeline
