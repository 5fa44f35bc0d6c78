#include "io/ply_header.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/number_text.hpp"
#include "io/bytes.hpp"
#include "io/cloud_columns.hpp"

namespace cairn::io::ply {
namespace {

using geometry::ScalarType;

std::optional<ScalarType> type_named(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, ScalarType>, 20> kTypes = {{
      {"char", ScalarType::i8},     {"int8", ScalarType::i8},     {"uchar", ScalarType::u8},
      {"uint8", ScalarType::u8},    {"short", ScalarType::i16},   {"int16", ScalarType::i16},
      {"ushort", ScalarType::u16},  {"uint16", ScalarType::u16},  {"int", ScalarType::i32},
      {"int32", ScalarType::i32},   {"uint", ScalarType::u32},    {"uint32", ScalarType::u32},
      {"float", ScalarType::f32},   {"float32", ScalarType::f32}, {"double", ScalarType::f64},
      {"float64", ScalarType::f64}, {"int64", ScalarType::i64},   {"uint64", ScalarType::u64},
      {"long", ScalarType::i64},    {"ulong", ScalarType::u64},
  }};
  const auto* found = std::ranges::find(kTypes, name, &std::pair<std::string_view, ScalarType>::first);
  if (found == kTypes.end()) return std::nullopt;
  return found->second;
}

ScalarType need_type(std::string_view name, const TextReader& in) {
  if (const auto type = type_named(name)) return *type;
  throw in.error("unknown property type")
      .found("'" + std::string(name.substr(0, 40)) + "'")
      .allowed("char, uchar, short, ushort, int, uint, float, double, int8 to uint64, float32, float64");
}

Encoding need_encoding(std::string_view name, const TextReader& in) {
  if (name == "ascii") return Encoding::ascii;
  if (name == "binary_little_endian") return Encoding::little;
  if (name == "binary_big_endian") return Encoding::big;
  throw in.error("unknown PLY format")
      .found("'" + std::string(name.substr(0, 40)) + "'")
      .allowed("ascii, binary_little_endian, binary_big_endian");
}

Property read_property(std::string_view line, const TextReader& in) {
  Property property;
  std::string_view word = take_word(line);
  if (word == "list") {
    property.count_type = need_type(take_word(line), in);
    if (*property.count_type == ScalarType::f32 || *property.count_type == ScalarType::f64)
      throw in.error("the length of a list must be an integer type");
    word = take_word(line);
  }
  property.type = need_type(word, in);
  property.name = std::string(take_word(line));
  if (property.name.empty()) throw in.error("a property without a name");
  return property;
}

}  // namespace

std::string_view name_of(Encoding encoding) {
  switch (encoding) {
    case Encoding::ascii: return "ascii";
    case Encoding::little: return "binary_little_endian";
    case Encoding::big: return "binary_big_endian";
  }
  return "ascii";
}

bool Element::has_lists() const {
  return std::ranges::any_of(properties, [](const Property& p) { return p.count_type.has_value(); });
}

std::size_t Element::least_bytes() const {
  std::size_t bytes = 0;
  for (const auto& p : properties) bytes += size_of(p.count_type.value_or(p.type));
  return bytes;
}

Header parse_header(std::string_view text, const std::string& file) {
  TextReader in(text, file);
  Header header;
  const auto magic = in.next_line();
  if (!magic || base::trim(*magic) != "ply")
    throw bad_bytes(file, 0, "not a PLY file").allowed("'ply' on the first line");
  bool has_format = false;
  for (;;) {
    const auto next = in.next_line();
    if (!next) throw in.error("the header does not end").allowed("a line 'end_header'").hint("The file is truncated");
    std::string_view line = *next;
    const std::string_view keyword = take_word(line);
    if (keyword == "end_header") break;
    if (keyword.empty()) continue;
    if (keyword == "format") {
      header.encoding = need_encoding(take_word(line), in);
      if (base::trim(line) != "1.0") throw in.error("unknown PLY version").allowed("1.0");
      has_format = true;
    } else if (keyword == "comment" || keyword == "obj_info") {
      const std::string comment = printable_text(std::as_bytes(std::span(base::trim(line))));
      if (comment.starts_with("crs ") && header.crs.empty()) header.crs = comment.substr(4);
      else header.comments.push_back(comment);
    } else if (keyword == "element") {
      Element element;
      element.name = std::string(take_word(line));
      const auto count = base::parse_integer(take_word(line));
      if (!count || *count < 0 || element.name.empty())
        throw in.error("an element needs a name and a count of at least 0");
      element.count = static_cast<std::uint64_t>(*count);
      header.elements.push_back(std::move(element));
    } else if (keyword == "property") {
      if (header.elements.empty()) throw in.error("a property before the first element");
      Property property = read_property(line, in);
      auto& properties = header.elements.back().properties;
      if (std::ranges::find(properties, property.name, &Property::name) != properties.end())
        throw in.error("the property '" + property.name.substr(0, 40) + "' is declared twice");
      properties.push_back(std::move(property));
    } else {
      throw in.error("unknown keyword in the PLY header").found("'" + std::string(keyword.substr(0, 40)) + "'");
    }
  }
  if (!has_format) throw in.error("the header has no 'format' line");
  header.body = in.offset();
  header.body_line = in.line() + 1;
  return header;
}

}  // namespace cairn::io::ply
