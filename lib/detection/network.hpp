// A loaded network; the inference library stays behind it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "detection/decoder.hpp"
#include "detection/letterbox.hpp"
#include "detection/tensor.hpp"
#include "geometry/colour_image.hpp"

namespace cairn::detection {

// Not for two threads at once: give each its own. Runs on one thread, so that results do not depend on their number.
class Network {
 public:
  // model: the ONNX file's bytes; outputs: names of the tensors wanted, in this order. Throws invalid_input with the
  // file, what the library said, and the remedy where it cannot load the model.
  Network(std::string_view model, const std::filesystem::path& path, std::vector<std::string> outputs,
          const InputSize& input);
  ~Network();
  Network(Network&&) noexcept;
  Network& operator=(Network&&) noexcept;

  // The part of the image named by the letterbox, scaled and placed as it says on grey (114), values made by
  // `preprocessing`. Throws invalid_input where the library cannot compute the network.
  [[nodiscard]] std::vector<Tensor> run(const geometry::ColourImage& image, const Letterbox& fit,
                                        const Preprocessing& preprocessing);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::detection
