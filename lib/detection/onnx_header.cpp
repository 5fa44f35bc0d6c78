#include "detection/onnx_header.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <set>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::detection {
namespace {

using base::Error;
using base::ErrorCode;

// One message of a protocol buffer.
class Message {
 public:
  Message(std::string_view bytes, std::size_t offset, std::string_view file)
      : bytes_(bytes), offset_(offset), file_(file) {}

  struct Field {
    std::uint64_t number = 0;
    int type = 0;
    std::uint64_t value = 0;  // type 0
    std::string_view bytes;   // type 2
    std::size_t offset = 0;   // of bytes in the file
    [[nodiscard]] bool is(std::uint64_t n, int t) const { return number == n && type == t; }
  };

  bool next(Field& field) {
    if (at_ >= bytes_.size()) return false;
    const std::uint64_t key = varint();
    field = {key >> 3U, static_cast<int>(key & 7U), 0, {}, 0};
    switch (field.type) {
      case 0: field.value = varint(); return true;
      case 1: skip(8); return true;
      case 5: skip(4); return true;
      case 2: {
        const std::uint64_t length = varint();
        if (length > bytes_.size() - at_) throw error("a field reaches past the end");
        field.bytes = bytes_.substr(at_, static_cast<std::size_t>(length));
        field.offset = offset_ + at_;
        at_ += static_cast<std::size_t>(length);
        return true;
      }
      default: throw error("not a protocol buffer");
    }
  }

  [[nodiscard]] Message open(const Field& field) const { return {field.bytes, field.offset, file_}; }

 private:
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      if (at_ >= bytes_.size()) throw error("a number is cut off");
      const auto byte = static_cast<unsigned char>(bytes_[at_++]);
      value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
      if ((byte & 0x80U) == 0) return value;
    }
    throw error("a number is too long");
  }
  void skip(std::size_t count) {
    if (count > bytes_.size() - at_) throw error("a field reaches past the end");
    at_ += count;
  }
  [[nodiscard]] Error error(const std::string& message) const {
    return Error(ErrorCode::invalid_input, "not an ONNX model: " + message)
        .file(file_)
        .record("byte " + std::to_string(offset_ + at_))
        .hint("Export the model to ONNX again, and check that the file was copied whole");
  }

  std::string_view bytes_;
  std::size_t offset_;
  std::string_view file_;
  std::size_t at_ = 0;
};

void each(Message message, const std::function<void(const Message&, const Message::Field&)>& body) {
  Message::Field field;
  while (message.next(field)) body(message, field);
}

std::int64_t dimension(Message message) {
  std::int64_t size = -1;
  each(message, [&](const Message&, const Message::Field& f) {
    if (f.is(1, 0) && f.value <= (std::uint64_t{1} << 40U)) size = static_cast<std::int64_t>(f.value);
  });
  return size > 0 ? size : -1;
}

// ValueInfoProto: name = 1, type = 2 { tensor_type = 1 { shape = 2 { dim = 1 } } }
OnnxValue value_info(const Message& message) {
  OnnxValue value;
  each(message, [&](const Message& m, const Message::Field& f) {
    if (f.is(1, 2)) value.name = f.bytes;
    if (!f.is(2, 2)) return;
    each(m.open(f), [&](const Message& type, const Message::Field& t) {
      if (!t.is(1, 2)) return;
      each(type.open(t), [&](const Message& tensor, const Message::Field& s) {
        if (!s.is(2, 2)) return;
        each(tensor.open(s), [&](const Message& shape, const Message::Field& d) {
          if (d.is(1, 2)) value.dims.push_back(dimension(shape.open(d)));
        });
      });
    });
  });
  return value;
}

// GraphProto: initializer = 5 (TensorProto: name = 8), input = 11, output = 12
void read_graph(const Message& graph, OnnxHeader& header) {
  std::set<std::string> weights;
  each(graph, [&](const Message& m, const Message::Field& f) {
    if (f.is(5, 2))
      each(m.open(f), [&](const Message&, const Message::Field& t) {
        if (t.is(8, 2)) weights.emplace(t.bytes);
      });
    if (f.is(11, 2)) header.inputs.push_back(value_info(m.open(f)));
    if (f.is(12, 2)) header.outputs.push_back(value_info(m.open(f)));
  });
  std::erase_if(header.inputs, [&](const OnnxValue& v) { return weights.contains(v.name); });
}

}  // namespace

const std::string* OnnxHeader::find(std::string_view key) const {
  for (const auto& [name, value] : metadata)
    if (name == key) return &value;
  return nullptr;
}

OnnxHeader read_onnx_header(std::string_view bytes, std::string_view name) {
  OnnxHeader header;
  bool graph = false;
  // ModelProto: graph = 7, metadata_props = 14 (key = 1, value = 2)
  each(Message(bytes, 0, name), [&](const Message& m, const Message::Field& f) {
    if (f.is(7, 2)) {
      graph = true;
      read_graph(m.open(f), header);
    }
    if (!f.is(14, 2)) return;
    std::pair<std::string, std::string> entry;
    each(m.open(f), [&](const Message&, const Message::Field& p) {
      if (p.is(1, 2)) entry.first = p.bytes;
      if (p.is(2, 2)) entry.second = p.bytes;
    });
    header.metadata.push_back(std::move(entry));
  });
  if (!graph || header.inputs.empty() || header.outputs.empty())
    throw Error(ErrorCode::invalid_input, "not an ONNX model: no graph with inputs and outputs")
        .file(name)
        .hint("Export the model to ONNX again, and check that the file was copied whole");
  return header;
}

std::vector<std::string> class_names_from_metadata(const OnnxHeader& header) {
  const std::string* text = header.find("names");
  if (text == nullptr) return {};
  std::map<std::int64_t, std::string> names;
  std::string_view rest = *text;
  const auto trimmed_front = [&] {
    const auto at = rest.find_first_not_of(" ,{\n\r\t");
    rest = at == std::string_view::npos ? std::string_view() : rest.substr(at);
  };
  for (trimmed_front(); !rest.empty() && rest.front() != '}'; trimmed_front()) {
    const auto colon = rest.find(':');
    if (colon == std::string_view::npos) return {};
    const auto number = base::parse_integer(rest.substr(0, colon));
    rest.remove_prefix(colon + 1);
    trimmed_front();
    if (!number || rest.empty() || (rest.front() != '\'' && rest.front() != '"')) return {};
    const auto end = rest.find(rest.front(), 1);
    if (end == std::string_view::npos) return {};
    names[*number] = rest.substr(1, end - 1);
    rest.remove_prefix(end + 1);
  }
  std::vector<std::string> list;
  for (const auto& [number, name] : names) {
    if (number != static_cast<std::int64_t>(list.size())) return {};
    list.push_back(name);
  }
  return list;
}

}  // namespace cairn::detection
