// The header of a PLY file. Internal to the PLY part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/point_cloud.hpp"

namespace cairn::io::ply {

enum class Encoding { ascii, little, big };

struct Property {
  std::string name;
  geometry::ScalarType type = geometry::ScalarType::f32;  // of the value, or of a list's items
  std::optional<geometry::ScalarType> count_type;         // set: the property is a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  [[nodiscard]] bool has_lists() const;
  // Bytes of a record whose lists are empty.
  [[nodiscard]] std::size_t least_bytes() const;
};

struct Header {
  Encoding encoding = Encoding::ascii;
  std::vector<Element> elements;
  std::vector<std::string> comments;  // also obj_info
  std::string crs;
  std::size_t body = 0;         // offset of the first byte behind the header
  std::uint64_t body_line = 0;  // 1-based number of that line
};

[[nodiscard]] std::string_view name_of(Encoding encoding);
[[nodiscard]] Header parse_header(std::string_view text, const std::string& file);

}  // namespace cairn::io::ply
