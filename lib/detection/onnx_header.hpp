// What an ONNX file says about itself: inputs, outputs, metadata. No weights are read.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cairn::detection {

struct OnnxValue {
  std::string name;
  std::vector<std::int64_t> dims;  // -1 where the size is open
};

struct OnnxHeader {
  std::vector<OnnxValue> inputs;  // those that are not weights
  std::vector<OnnxValue> outputs;
  std::vector<std::pair<std::string, std::string>> metadata;

  // nullptr where there is none.
  [[nodiscard]] const std::string* find(std::string_view key) const;
};

// Walks the protocol buffer of an ONNX model (onnx.proto3: ModelProto, GraphProto, ValueInfoProto). `name` stands for
// the file in messages. Throws invalid_input with the byte offset for a length past the end, a malformed number, or a
// file without a graph. Cost: linear in the number of fields, weights are stepped over.
[[nodiscard]] OnnxHeader read_onnx_header(std::string_view bytes, std::string_view name);

// Class names of Ultralytics' metadata member "names": {0: 'rock', 1: 'tree'}, by number; empty where it is none.
[[nodiscard]] std::vector<std::string> class_names_from_metadata(const OnnxHeader& header);

}  // namespace cairn::detection
