// Small ONNX files made by hand: a chain of nodes without weights.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace cairn::testing {

inline std::string varint(std::uint64_t value) {
  std::string bytes;
  while (value > 127) {
    bytes += static_cast<char>(static_cast<unsigned char>((value & 127U) | 128U));
    value >>= 7U;
  }
  return bytes + static_cast<char>(value);
}
inline std::string number_field(std::uint64_t field, std::uint64_t value) {
  return varint(field << 3U) + varint(value);
}
inline std::string bytes_field(std::uint64_t field, const std::string& bytes) {
  return varint((field << 3U) | 2U) + varint(bytes.size()) + bytes;
}

// dims of 0 stay open.
inline std::string onnx_value(const std::string& name, const std::vector<std::uint64_t>& dims) {
  std::string shape;
  for (const auto d : dims) shape += bytes_field(1, d > 0 ? number_field(1, d) : bytes_field(2, "open"));
  const std::string tensor = number_field(1, 1) + bytes_field(2, shape);
  return bytes_field(1, name) + bytes_field(2, bytes_field(1, tensor));
}

// input -> op -> output.
inline std::string onnx_model(const std::string& op, const std::vector<std::uint64_t>& dims,
                              const std::vector<std::pair<std::string, std::string>>& metadata = {}) {
  const std::string node =
      bytes_field(1, "image") + bytes_field(2, "result") + bytes_field(3, "only") + bytes_field(4, op);
  const std::string graph = bytes_field(1, node) + bytes_field(2, "graph") +
                            bytes_field(11, onnx_value("image", dims)) + bytes_field(12, onnx_value("result", dims));
  std::string model = number_field(1, 7) + bytes_field(7, graph) + bytes_field(8, number_field(2, 11));
  for (const auto& [key, value] : metadata) model += bytes_field(14, bytes_field(1, key) + bytes_field(2, value));
  return model;
}

}  // namespace cairn::testing
