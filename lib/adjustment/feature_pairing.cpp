#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "adjustment/image_features.hpp"

namespace cairn::adjustment {
namespace {

constexpr Eigen::Index kBlock = 512;  // features of a compared at once: bounds the memory

// Largest and second-largest product of one feature, and whose the largest is.
struct Best {
  int index = -1;
  float first = -2.0F, second = -2.0F;

  void offer(int candidate, float product) {
    if (product > first) {
      second = first;
      first = product;
      index = candidate;
    } else if (product > second) {
      second = product;
    }
  }
  // Products of unit vectors: distance^2 = 2 - 2 product.
  [[nodiscard]] bool passes(double ratio) const {
    const double near = 2.0 - 2.0 * static_cast<double>(first), far = 2.0 - 2.0 * static_cast<double>(second);
    return index >= 0 && near < ratio * ratio * far;
  }
};

using Descriptors = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Eigen::Map<const Descriptors> mapped(const std::vector<float>& units) {
  constexpr auto kWidth = static_cast<Eigen::Index>(kDescriptorBytes);
  return {units.data(), static_cast<Eigen::Index>(units.size()) / kWidth, kWidth};
}

}  // namespace

std::vector<float> unit_descriptors(const ImageFeatures& features, std::size_t most) {
  const std::size_t n = std::min(most, features.size());
  std::vector<float> result(n * kDescriptorBytes);
  for (std::size_t f = 0; f < n; ++f) {
    const std::uint8_t* from = features.descriptors.data() + f * kDescriptorBytes;
    float* to = result.data() + f * kDescriptorBytes;
    float sum = 0.0F;
    for (std::size_t i = 0; i < kDescriptorBytes; ++i) sum += static_cast<float>(from[i]);
    const float scale = sum > 0.0F ? 1.0F / sum : 0.0F;
    for (std::size_t i = 0; i < kDescriptorBytes; ++i) to[i] = std::sqrt(static_cast<float>(from[i]) * scale);
  }
  return result;
}

std::vector<FeaturePair> pair_features(const ImageFeatures& a, const ImageFeatures& b, double ratio, std::size_t most) {
  std::vector<FeaturePair> result;
  if (std::min(a.size(), most) < 2 || std::min(b.size(), most) < 2) return result;
  const auto units_a = unit_descriptors(a, most), units_b = unit_descriptors(b, most);
  const auto rows_a = mapped(units_a), rows_b = mapped(units_b);
  std::vector<Best> of_a(std::min(a.size(), most)), of_b(std::min(b.size(), most));
  Descriptors products;
  for (Eigen::Index first = 0; first < rows_a.rows(); first += kBlock) {
    // Eigen's product is several times faster than cv::gemm where OpenCV has no BLAS.
    products.noalias() = rows_a.middleRows(first, std::min(kBlock, rows_a.rows() - first)) * rows_b.transpose();
    for (Eigen::Index i = 0; i < products.rows(); ++i) {
      auto& best = of_a[static_cast<std::size_t>(first + i)];
      for (int j = 0; j < products.cols(); ++j) {
        best.offer(j, products(i, j));
        of_b[static_cast<std::size_t>(j)].offer(static_cast<int>(first + i), products(i, j));
      }
    }
  }
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    if (!of_a[i].passes(ratio)) continue;
    const auto j = static_cast<std::size_t>(of_a[i].index);
    if (of_b[j].index != static_cast<int>(i) || !of_b[j].passes(ratio)) continue;
    result.push_back({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), of_a[i].first});
  }
  return result;
}

}  // namespace cairn::adjustment
