// Distinctive points of one image, and which of them look the same in two.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "geometry/grey_image.hpp"
#include "geometry/vec.hpp"

namespace cairn::adjustment {

inline constexpr std::size_t kDescriptorBytes = 128;

// SIFT (Lowe 2004) of one image, 144 bytes a feature.
struct ImageFeatures {
  std::vector<geometry::Vec2> pixels;     // of the image given, corner convention, px
  std::vector<std::uint8_t> descriptors;  // kDescriptorBytes a feature, OpenCV's integers 0..255
  double width_px = 0.0, height_px = 0.0;

  [[nodiscard]] std::size_t size() const { return pixels.size(); }
};

// Images wider than max_width_px are shrunk first (by area); the `max_features` strongest are kept. With `ranked`, they
// come in descending strength, and of those at one place (several orientations) only one is kept; else in OpenCV's
// order. The same on every run. Cost: about 0.25 s for 1000 x 560 px on one core, proportional to the pixels.
[[nodiscard]] ImageFeatures image_features(const geometry::GreyImage& image, std::int64_t max_width_px,
                                           std::int64_t max_features, bool ranked = false);

// RootSIFT (Arandjelovic and Zisserman 2012) of the first `most` features: kDescriptorBytes floats each, of unit
// length.
[[nodiscard]] std::vector<float> unit_descriptors(const ImageFeatures& features, std::size_t most);

struct FeaturePair {
  std::uint32_t a = 0, b = 0;  // indices of features
  float closeness = 0.0F;      // product of the unit descriptors, up to 1
};

// Nearest neighbours by RootSIFT among the first `most` features of each image that pass Lowe's ratio both ways and are
// each other's nearest, in the order of the features of a. Cost: 128 n_a n_b multiplications; memory 512 (n_a + n_b)
// bytes and 2 kB n_b.
[[nodiscard]] std::vector<FeaturePair> pair_features(const ImageFeatures& a, const ImageFeatures& b, double ratio,
                                                     std::size_t most = std::numeric_limits<std::size_t>::max());

}  // namespace cairn::adjustment
