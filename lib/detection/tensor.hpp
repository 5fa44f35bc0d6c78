// What a network gives back.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace cairn::detection {

struct TensorShape {
  std::string name;
  std::vector<std::size_t> dims;
};

struct Tensor {
  TensorShape shape;
  std::vector<float> values;  // row-major, as many as the product of dims
};

// "cls_8 1x1600x1, obj_8 1x1600x1".
[[nodiscard]] inline std::string describe(const std::vector<TensorShape>& shapes) {
  std::string text;
  for (const auto& s : shapes) {
    text += (text.empty() ? "" : ", ") + s.name + " ";
    for (std::size_t i = 0; i < s.dims.size(); ++i) text += (i == 0 ? "" : "x") + std::to_string(s.dims[i]);
  }
  return text;
}

}  // namespace cairn::detection
