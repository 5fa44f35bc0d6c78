// Distinctive points of one image, and which of them look the same in two.
#pragma once

#include <cstddef>
#include <cstdint>
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

// Images wider than max_width_px are shrunk first (by area); the `max_features` strongest are kept. With `distinct`, of
// the features at one place (several orientations) only the first is kept. The same on every run.
// Cost: about 0.25 s for 1000 x 560 px on one core, proportional to the pixels.
[[nodiscard]] ImageFeatures image_features(const geometry::GreyImage& image, std::int64_t max_width_px,
                                           std::int64_t max_features, bool distinct = false);

struct FeaturePair {
  std::uint32_t a = 0, b = 0;  // indices of features
  float closeness = 0.0F;      // product of the unit descriptors, up to 1
};

// Nearest neighbours by RootSIFT (Arandjelovic and Zisserman 2012) that pass Lowe's ratio both ways and are each
// other's nearest, in the order of the features of a. Cost: 128 n_a n_b multiplications; memory 512 (n_a + n_b) bytes
// and 2 kB n_b.
[[nodiscard]] std::vector<FeaturePair> pair_features(const ImageFeatures& a, const ImageFeatures& b, double ratio);

}  // namespace cairn::adjustment
