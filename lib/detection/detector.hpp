// A detector: photographs to boxes.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "detection/options.hpp"
#include "detection/suppression.hpp"
#include "geometry/colour_image.hpp"

namespace cairn::detection {

struct DetectorFacts {
  std::string decoder;  // its name
  std::size_t input_width_px = 0, input_height_px = 0;
  std::string outputs;  // names and shapes
  std::vector<std::string> classes;
};

// An ONNX detector. Input size and class names come from the model where it has them; the decoder is recognised from
// its outputs. Photos larger than the tiles are cut, boxes are joined at the seams (tiles.hpp).
// May be used by several threads at once; each works on a copy of the network of its own. Same bytes whatever their
// number.
class Detector {
 public:
  // class_names: "" entries and missing ones are taken from the model, else "class_3" (a single class: "face" for the
  // face detectors' decoders, "object").
  // Throws not_found, or invalid_input with file and remedy: no ONNX model, one that OpenCV cannot load or compute, an
  // input that is not one three-channel image, outputs of no known detector (with their shapes), more class names than
  // classes.
  Detector(const std::filesystem::path& model, const DetectOptions& options, std::vector<std::string> class_names);
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  [[nodiscard]] const DetectorFacts& facts() const;

  // Boxes in image px (corner convention), clipped to the image, by falling score. Empty for an empty image.
  [[nodiscard]] std::vector<ScoredBox> detect(const geometry::ColourImage& image) const;
  // Name of a class number of detect().
  [[nodiscard]] const std::string& class_name(std::size_t object_class) const;
  // Number of network runs detect() needs for an image of this size.
  [[nodiscard]] std::size_t tiles_of(std::size_t width_px, std::size_t height_px) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::detection
