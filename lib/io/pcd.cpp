#include "io/pcd.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "io/bytes.hpp"
#include "io/cloud_columns.hpp"
#include "io/lzf.hpp"

namespace cairn::io {
namespace {

using geometry::ScalarType;

constexpr std::size_t kMaxColumns = 4096;
constexpr std::size_t kPiecePoints = 4096;

enum class Encoding { ascii, binary, compressed };

struct Header {
  std::vector<NamedColumn> columns;  // one a value: fields with a count above 1 are spread
  std::uint64_t points = 0;
  Encoding encoding = Encoding::ascii;
  std::string version, viewpoint;
  std::size_t body = 0;
  std::uint64_t body_line = 0;

  [[nodiscard]] std::size_t stride() const {
    std::size_t bytes = 0;
    for (const auto& c : columns) bytes += size_of(c.type);
    return bytes;
  }
};

std::vector<std::string> words_of(std::string_view line) {
  std::vector<std::string> words;
  for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) words.emplace_back(word);
  return words;
}

std::uint64_t need_count(const std::vector<std::string>& words, std::size_t i, const TextReader& in) {
  const auto v = i < words.size() ? base::parse_integer(words[i]) : std::nullopt;
  if (!v || *v < 0)
    throw in.error("a whole number of at least 0 is needed")
        .found(i < words.size() ? "'" + words[i].substr(0, 40) + "'" : "nothing");
  return static_cast<std::uint64_t>(*v);
}

ScalarType type_of(char kind, std::uint64_t size, const TextReader& in) {
  if (kind == 'F' && size == 4) return ScalarType::f32;
  if (kind == 'F' && size == 8) return ScalarType::f64;
  if (kind == 'U' || kind == 'I') {
    const bool is_signed = kind == 'I';
    switch (size) {
      case 1: return is_signed ? ScalarType::i8 : ScalarType::u8;
      case 2: return is_signed ? ScalarType::i16 : ScalarType::u16;
      case 4: return is_signed ? ScalarType::i32 : ScalarType::u32;
      case 8: return is_signed ? ScalarType::i64 : ScalarType::u64;
      default: break;
    }
  }
  throw in.error("unknown type of a field")
      .found(std::string(1, kind >= ' ' && kind <= '~' ? kind : '?') + std::to_string(size))
      .allowed("F4, F8, U1, U2, U4, U8, I1, I2, I4, I8");
}

Header parse_header(std::string_view text, const std::string& file) {
  TextReader in(text, file);
  Header header;
  std::vector<std::string> fields, sizes, types, counts;
  std::optional<std::uint64_t> width, height, points;
  for (;;) {
    const auto next = in.next_line();
    if (!next)
      throw in.error("the header does not end").allowed("a line 'DATA'").hint("The file is truncated or no PCD file");
    std::vector<std::string> words = words_of(*next);
    if (words.empty() || words[0].starts_with('#')) continue;
    const std::string keyword = words[0];
    words.erase(words.begin());
    if (keyword == "VERSION") header.version = words.empty() ? "" : printable_text(std::as_bytes(std::span(words[0])));
    else if (keyword == "FIELDS" || keyword == "COLUMNS") fields = words;
    else if (keyword == "SIZE") sizes = words;
    else if (keyword == "TYPE") types = words;
    else if (keyword == "COUNT") counts = words;
    else if (keyword == "WIDTH") width = need_count(words, 0, in);
    else if (keyword == "HEIGHT") height = need_count(words, 0, in);
    else if (keyword == "POINTS") points = need_count(words, 0, in);
    else if (keyword == "VIEWPOINT") header.viewpoint = printable_text(std::as_bytes(std::span(base::trim(*next))));
    else if (keyword == "DATA") {
      const std::string data = words.empty() ? "" : words[0];
      if (data == "ascii") header.encoding = Encoding::ascii;
      else if (data == "binary") header.encoding = Encoding::binary;
      else if (data == "binary_compressed") header.encoding = Encoding::compressed;
      else
        throw in.error("unknown kind of data")
            .found("'" + printable_text(std::as_bytes(std::span(data))) + "'")
            .allowed("ascii, binary, binary_compressed");
      break;
    } else {
      throw in.error("unknown keyword in the PCD header")
          .found("'" + printable_text(std::as_bytes(std::span(keyword))).substr(0, 40) + "'");
    }
  }
  if (sizes.size() != fields.size() || types.size() != fields.size() ||
      (!counts.empty() && counts.size() != fields.size()))
    throw in.error("FIELDS, SIZE, TYPE and COUNT differ in length");
  for (std::size_t f = 0; f < fields.size(); ++f) {
    const ScalarType type = type_of(types[f].empty() ? ' ' : types[f][0], need_count(sizes, f, in), in);
    const std::uint64_t count = counts.empty() ? 1 : need_count(counts, f, in);
    if (count > kMaxColumns || header.columns.size() + count > kMaxColumns)
      throw in.error("too many values a point").allowed("at most " + std::to_string(kMaxColumns));
    for (std::uint64_t k = 0; k < count; ++k) {
      std::string name = printable_text(std::as_bytes(std::span(fields[f])));
      if (count > 1) name += "_" + std::to_string(k);
      header.columns.push_back({std::move(name), type, fields[f] == "_"});
    }
  }
  if (points) {
    header.points = *points;
  } else if (width) {
    const std::uint64_t rows = height.value_or(1);
    if (rows != 0 && *width > std::numeric_limits<std::uint64_t>::max() / rows)
      throw in.error("WIDTH times HEIGHT is too large");
    header.points = *width * rows;
  } else {
    throw in.error("the header has neither POINTS nor WIDTH");
  }
  header.body = in.offset();
  header.body_line = in.line() + 1;
  return header;
}

// Columns of values of one type each: where point i of column c lies.
struct Layout {
  std::vector<std::size_t> offset, step;
};

void fill(geometry::PointCloud& cloud, const std::vector<Slot>& slots, const Layout& layout, const std::byte* data,
          std::size_t n) {
  base::parallel_for(n, kPiecePoints, [&](std::size_t first, std::size_t last) {
    for (std::size_t c = 0; c < slots.size(); ++c) {
      const Slot slot = slots[c];
      if (slot.role == Role::skip) continue;
      // The bits of a packed colour are taken as they are, whatever the type says.
      const ScalarType type = slot.role == Role::packed_colour ? ScalarType::u32 : slot.type;
      with_type(type, [&](auto kind) {
        for (std::size_t i = first; i < last; ++i)
          put_value(cloud, slot, i,
                    static_cast<double>(load_le<decltype(kind)>(data + layout.offset[c] + i * layout.step[c])));
      });
    }
  });
}

void read_ascii(const FileBytes& file, const Header& header, const std::vector<Slot>& slots,
                geometry::PointCloud& cloud) {
  TextReader in(file.text().substr(header.body), file.name(), header.body_line);
  for (std::size_t i = 0; i < cloud.size(); ++i)
    for (const Slot& slot : slots) {
      const auto word = in.next_word();
      if (!word)
        throw in.error("the file ends inside the points")
            .found(std::to_string(i) + " points")
            .allowed(std::to_string(cloud.size()))
            .hint("The file is truncated");
      const auto v = parse_number(*word);
      if (!v)
        throw in.error("not a number").found("'" + printable_text(std::as_bytes(std::span(word->substr(0, 40)))) + "'");
      double value = *v;
      // Packed colours are written either as the integer or as the float of the same bits.
      if (slot.role == Role::packed_colour && slot.type == ScalarType::f32 &&
          (value != std::floor(value) || std::abs(value) < 1.0 ||
           word->find_first_of(".eE") != std::string_view::npos)) {
        const auto narrow = static_cast<float>(value);
        value = static_cast<double>(std::bit_cast<std::uint32_t>(narrow));
      }
      put_value(cloud, slot, i, value);
    }
}

base::Error too_many(const FileBytes& file, const Header& header, std::uint64_t room) {
  return bad_bytes(file.name(), header.body, "the header promises more points than the file holds")
      .found(std::to_string(header.points))
      .allowed("at most " + std::to_string(room) + " in the " + std::to_string(file.bytes().size() - header.body) +
               " bytes behind the header")
      .hint("The file is truncated or its header is wrong");
}

std::string_view name_of(Encoding encoding) {
  if (encoding == Encoding::ascii) return "ascii";
  return encoding == Encoding::binary ? "binary" : "binary_compressed";
}

}  // namespace

CloudData read_pcd(const std::filesystem::path& path) {
  const FileBytes file(path);
  const Header header = parse_header(file.text(), file.name());
  CloudData data;
  data.facts.format = "PCD";
  data.facts.version = header.version + ", " + std::string(name_of(header.encoding));
  data.facts.declared_points = header.points;
  if (!header.viewpoint.empty()) data.facts.comments.push_back(header.viewpoint);
  int positions = 0;
  std::vector<Slot> slots = assign_slots(header.columns, positions);
  if (positions != 3)
    throw bad_line(file.name(), header.body_line - 1, "the points lack a coordinate")
        .found(std::to_string(positions) + " of x, y, z")
        .allowed("x, y and z");
  const std::uint64_t left = file.bytes().size() - header.body;
  const std::size_t stride = header.stride();
  std::unique_ptr<std::byte[]> unpacked;
  const std::byte* points = file.bytes().data() + header.body;
  Layout layout;
  std::size_t offset = 0;
  const auto n = static_cast<std::size_t>(header.points);
  switch (header.encoding) {
    case Encoding::ascii:
      // A word and a separator each; the last may lack its separator.
      if (header.points > (left + 1) / (2 * header.columns.size()))
        throw too_many(file, header, (left + 1) / (2 * header.columns.size()));
      break;
    case Encoding::binary:
      if (header.points > left / stride) throw too_many(file, header, left / stride);
      for (const auto& c : header.columns) {
        layout.offset.push_back(offset);
        layout.step.push_back(stride);
        offset += size_of(c.type);
      }
      break;
    case Encoding::compressed: {
      if (n == 0) break;
      ByteReader in(file.bytes().subspan(header.body), file.name(), header.body);
      const std::uint64_t packed = in.read<std::uint32_t>("the size of the compressed points");
      const std::uint64_t size = in.read<std::uint32_t>("the size of the points");
      const Bytes bytes = in.bytes(packed, "the compressed points");
      if (size > packed * kLzfMaxRatio || header.points > size / stride || size != header.points * stride)
        throw bad_bytes(file.name(), header.body + 4, "the size of the compressed points is impossible")
            .found(std::to_string(size) + " bytes from " + std::to_string(packed))
            .allowed(std::to_string(header.points) + " points of " + std::to_string(stride) + " bytes");
      unpacked = std::make_unique_for_overwrite<std::byte[]>(static_cast<std::size_t>(size));
      if (!lzf_decompress(bytes, {unpacked.get(), static_cast<std::size_t>(size)}))
        throw bad_bytes(file.name(), header.body + 8, "the compressed points are damaged");
      points = unpacked.get();
      for (const auto& c : header.columns) {
        layout.offset.push_back(offset);
        layout.step.push_back(size_of(c.type));
        offset += size_of(c.type) * n;
      }
      break;
    }
  }
  make_columns(data.cloud, header.columns, slots, n);
  if (header.encoding == Encoding::ascii) read_ascii(file, header, slots, data.cloud);
  else if (n > 0) fill(data.cloud, slots, layout, points, n);
  drop_non_finite(data);
  return data;
}

namespace {

struct OutField {
  std::string name;
  ScalarType type;
};

char kind_of(ScalarType type) {
  switch (type) {
    case ScalarType::u8:
    case ScalarType::u16:
    case ScalarType::u32:
    case ScalarType::u64: return 'U';
    case ScalarType::f32:
    case ScalarType::f64: return 'F';
    default: return 'I';
  }
}

template <typename T>
T within(double v) {
  if constexpr (std::is_floating_point_v<T>) {
    constexpr auto kReach = static_cast<double>(std::numeric_limits<T>::max());
    return static_cast<T>(std::clamp(v, -kReach, kReach));
  } else {
    // The largest 64-bit integers round up as doubles: stay below.
    constexpr double kLo = static_cast<double>(std::numeric_limits<T>::lowest());
    constexpr double kHi = sizeof(T) == 8 ? (std::is_signed_v<T> ? 9223372036854774784.0 : 18446744073709549568.0)
                                          : static_cast<double>(std::numeric_limits<T>::max());
    return static_cast<T>(std::clamp(std::round(v), kLo, kHi));
  }
}

std::string one_word(std::string text) {
  for (char& c : text)
    if (c <= ' ' || c > '~') c = '_';
  return text.empty() ? "field" : text;
}

}  // namespace

void write_pcd(const std::filesystem::path& path, const geometry::PointCloud& cloud) {
  const auto bad = [&](std::string message) {
    return base::Error(base::ErrorCode::invalid_argument, std::move(message)).file(path.string());
  };
  if (!cloud.consistent()) throw bad("the columns of the cloud differ in length");
  std::vector<OutField> fields = {{"x", ScalarType::f64}, {"y", ScalarType::f64}, {"z", ScalarType::f64}};
  if (!cloud.normals.empty())
    for (const char* name : {"normal_x", "normal_y", "normal_z"}) fields.push_back({name, ScalarType::f32});
  if (!cloud.colours.empty()) fields.push_back({"rgb", ScalarType::u32});
  if (!cloud.intensity.empty()) fields.push_back({"intensity", ScalarType::u16});
  if (!cloud.classification.empty()) fields.push_back({"classification", ScalarType::u8});
  if (!cloud.gps_time.empty()) fields.push_back({"gps_time", ScalarType::f64});
  for (const auto& column : cloud.scalars) fields.push_back({one_word(column.name), column.type});
  std::string names = "FIELDS", sizes = "SIZE", types = "TYPE", counts = "COUNT";
  for (const auto& f : fields) {
    names += " " + f.name;
    sizes += " " + std::to_string(size_of(f.type));
    types += std::string(" ") + kind_of(f.type);
    counts += " 1";
  }
  const std::string n = std::to_string(cloud.size());
  OutputFile out(path);
  out.write("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n" + names + "\n" + sizes + "\n" + types + "\n" +
            counts + "\nWIDTH " + n + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + n + "\nDATA binary\n");
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.positions[i].allFinite()) throw bad("a coordinate is not finite").record("point " + std::to_string(i));
    for (int axis = 0; axis < 3; ++axis) out.put(cloud.positions[i][axis]);
    if (!cloud.normals.empty())
      for (int axis = 0; axis < 3; ++axis) {
        const double v = cloud.normals[i][axis];
        out.put(std::isfinite(v) ? static_cast<float>(v) : 0.0F);
      }
    if (!cloud.colours.empty()) {
      const auto& c = cloud.colours[i];
      out.put(static_cast<std::uint32_t>((c[0] >> 8U) << 16U | (c[1] >> 8U) << 8U | c[2] >> 8U));
    }
    if (!cloud.intensity.empty()) out.put(cloud.intensity[i]);
    if (!cloud.classification.empty()) out.put(cloud.classification[i]);
    if (!cloud.gps_time.empty()) out.put(std::isfinite(cloud.gps_time[i]) ? cloud.gps_time[i] : 0.0);
    for (const auto& column : cloud.scalars) {
      const double v = std::isfinite(column.values[i]) ? column.values[i] : kNoDataValue;
      with_type(column.type, [&](auto kind) { out.put(within<decltype(kind)>(v)); });
    }
  }
  out.close();
}

}  // namespace cairn::io
