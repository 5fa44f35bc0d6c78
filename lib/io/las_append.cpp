#include "io/las_append.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string_view>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/bytes.hpp"
#include "io/las_header.hpp"
#include "io/las_layout.hpp"
#include "io/las_plan.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::ScalarType;
using las::store;

// Places in the public header block (LAS 1.4-R16, table 3).
constexpr std::size_t kEncodingAt = 6, kHeaderSizeAt = 94, kPointsAt = 96, kRecordsAt = 100, kRecordLengthAt = 105,
                      kLongRecordsAt = 235;
constexpr std::size_t kRecordHeader = 54;
constexpr std::uint64_t kPiecePoints = 65536;

template <typename T>
T load(const std::vector<std::byte>& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

template <typename T>
void store_integer(std::byte* to, double value, const LasAddition& a, std::uint64_t point) {
  const double rounded = std::round(value);
  if (!(rounded >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
        rounded <= static_cast<double>(std::numeric_limits<T>::max())))
    throw Error(ErrorCode::invalid_argument, "a value of '" + a.name + "' does not fit its type")
        .record("point " + std::to_string(point))
        .found(base::to_text(value));
  store(to, static_cast<T>(rounded));
}

void store_value(std::byte* to, double value, const LasAddition& a, std::uint64_t point) {
  switch (a.type) {
    case ScalarType::u8: return store_integer<std::uint8_t>(to, value, a, point);
    case ScalarType::i8: return store_integer<std::int8_t>(to, value, a, point);
    case ScalarType::u16: return store_integer<std::uint16_t>(to, value, a, point);
    case ScalarType::i16: return store_integer<std::int16_t>(to, value, a, point);
    case ScalarType::u32: return store_integer<std::uint32_t>(to, value, a, point);
    case ScalarType::i32: return store_integer<std::int32_t>(to, value, a, point);
    case ScalarType::f32:
    case ScalarType::f64: break;
    case ScalarType::u64:
    case ScalarType::i64:
      throw Error(ErrorCode::invalid_argument, "dimensions of 64 bits are not appended").found(a.name);
  }
  if (!std::isfinite(value))
    throw Error(ErrorCode::invalid_argument, "a value of '" + a.name + "' is not finite")
        .record("point " + std::to_string(point));
  if (a.type == ScalarType::f32) store(to, static_cast<float>(value));
  else store(to, value);
}

std::vector<std::byte> descriptor(const LasAddition& a) {
  std::vector<std::byte> bytes(las::kExtraBytesDescriptor);
  const auto type = std::ranges::find(las::kExtraTypes, a.type) - las::kExtraTypes.begin();
  bytes[2] = static_cast<std::byte>(type + 1);
  std::memcpy(bytes.data() + 4, a.name.data(), std::min<std::size_t>(a.name.size(), 32));
  std::memcpy(bytes.data() + 160, a.description.data(), std::min<std::size_t>(a.description.size(), 32));
  return bytes;
}

// Where the described part of a point record ends: standard fields and every descriptor, of known or unknown use.
std::size_t described_end(const std::vector<std::byte>& old, int point_format) {
  std::size_t end = las::kLayouts[static_cast<std::size_t>(point_format)].length;
  std::size_t at = load<std::uint16_t>(old, kHeaderSizeAt);
  for (auto left = load<std::uint32_t>(old, kRecordsAt); left > 0; --left) {
    const std::size_t length = load<std::uint16_t>(old, at + 20);
    const std::string_view user(reinterpret_cast<const char*>(old.data() + at + 2), las::kSpecUser.size());
    if (user == las::kSpecUser && load<std::uint16_t>(old, at + 18) == las::kExtraBytesRecord)
      for (std::size_t d = 0; (d + 1) * las::kExtraBytesDescriptor <= length; ++d) {
        const std::byte* from = old.data() + at + kRecordHeader + d * las::kExtraBytesDescriptor;
        const auto code = std::to_integer<std::size_t>(from[2]);
        if (code > 30)
          throw Error(ErrorCode::failed_precondition, "an extra dimension has an unknown type")
              .found(std::to_string(code));
        end += code == 0 ? std::to_integer<std::size_t>(from[3])
                         : las::size_of(las::kExtraTypes[(code - 1) % 10]) * ((code - 1) / 10 + 1);
      }
    at += kRecordHeader + length;
  }
  return end;
}

// Header and short records with `added` descriptors more; lengths and offsets are still to be set.
struct Front {
  std::vector<std::byte> bytes;
  std::uint32_t records = 0;
};

Front front_with(const std::vector<std::byte>& old, const std::vector<std::byte>& added) {
  const std::size_t header_size = load<std::uint16_t>(old, kHeaderSizeAt);
  Front front{{old.begin(), old.begin() + static_cast<std::ptrdiff_t>(header_size)},
              load<std::uint32_t>(old, kRecordsAt)};
  bool placed = added.empty();
  std::size_t at = header_size;
  for (std::uint32_t i = 0; i < front.records; ++i) {
    const std::size_t length = load<std::uint16_t>(old, at + 20);
    const auto begin = old.begin() + static_cast<std::ptrdiff_t>(at);
    const std::size_t start = front.bytes.size();
    front.bytes.insert(front.bytes.end(), begin, begin + static_cast<std::ptrdiff_t>(kRecordHeader + length));
    at += kRecordHeader + length;
    const std::string_view user(reinterpret_cast<const char*>(front.bytes.data() + start + 2), las::kSpecUser.size());
    if (placed || user != las::kSpecUser || load<std::uint16_t>(front.bytes, start + 18) != las::kExtraBytesRecord)
      continue;
    if (length + added.size() > std::numeric_limits<std::uint16_t>::max())
      throw Error(ErrorCode::failed_precondition, "too many extra dimensions for one LAS record");
    store(front.bytes.data() + start + 20, static_cast<std::uint16_t>(length + added.size()));
    front.bytes.insert(front.bytes.end(), added.begin(), added.end());
    placed = true;
  }
  if (placed) return front;
  std::vector<std::byte> head(kRecordHeader);
  std::memcpy(head.data() + 2, las::kSpecUser.data(), las::kSpecUser.size());
  store(head.data() + 18, las::kExtraBytesRecord);
  store(head.data() + 20, static_cast<std::uint16_t>(added.size()));
  constexpr std::string_view kDescription = "extra bytes";
  std::memcpy(head.data() + 22, kDescription.data(), kDescription.size());
  front.bytes.insert(front.bytes.end(), head.begin(), head.end());
  front.bytes.insert(front.bytes.end(), added.begin(), added.end());
  ++front.records;
  return front;
}

}  // namespace

void append_las_dimensions(const std::filesystem::path& from, const std::filesystem::path& to,
                           const std::vector<LasAddition>& additions, const FillAdditions& fill) {
  const InputFile in(from);
  std::vector<std::string> ignored;
  const las::Header header = las::read_header(in, ignored);
  const std::uint64_t count = header.metadata.point_count;
  std::vector<std::byte> old(header.points_offset);
  in.read_at(0, old);
  if ((load<std::uint16_t>(old, kEncodingAt) & 2U) != 0)
    throw Error(ErrorCode::failed_precondition, "LAS files that hold waveforms are not appended to").file(in.name());

  // Where each addition goes in the record.
  std::vector<std::size_t> places;
  std::vector<std::byte> added;
  std::size_t stride = header.record_length;
  // Bytes that nothing describes get a descriptor, so that what follows is found.
  std::size_t bare = stride - std::min(stride, described_end(old, header.metadata.point_format));
  for (; bare > 0; bare -= std::min<std::size_t>(bare, 255)) {
    auto filler = descriptor({"undocumented", ScalarType::u8, ""});
    filler[2] = std::byte{0};
    filler[3] = static_cast<std::byte>(std::min<std::size_t>(bare, 255));
    added.insert(added.end(), filler.begin(), filler.end());
  }
  for (const LasAddition& a : additions) {
    const auto& known = header.metadata.dimensions;
    const auto same = std::ranges::find_if(known, [&](const LasDimension& d) { return d.name == a.name; });
    if (same == known.end()) {
      places.push_back(stride);
      stride += las::size_of(a.type);
      const auto more = descriptor(a);
      added.insert(added.end(), more.begin(), more.end());
      continue;
    }
    if (same->type != a.type || same->scaled())
      throw Error(ErrorCode::failed_precondition, "the file has a dimension of this name but of another type")
          .file(in.name())
          .found(a.name);
    places.push_back(header.dimension_offsets[static_cast<std::size_t>(same - known.begin())]);
  }
  if (stride > std::numeric_limits<std::uint16_t>::max())
    throw Error(ErrorCode::failed_precondition, "the point records become too long").file(in.name());

  Front front = front_with(old, added);
  const std::uint64_t old_end = header.points_offset + count * header.record_length;
  const std::uint64_t new_end = front.bytes.size() + count * stride;
  store(front.bytes.data() + kPointsAt, static_cast<std::uint32_t>(front.bytes.size()));
  store(front.bytes.data() + kRecordsAt, front.records);
  store(front.bytes.data() + kRecordLengthAt, static_cast<std::uint16_t>(stride));
  if (header.metadata.minor_version >= 4) {
    const auto long_records = load<std::uint64_t>(front.bytes, kLongRecordsAt);
    if (long_records >= old_end) store(front.bytes.data() + kLongRecordsAt, long_records - old_end + new_end);
  }

  OutputFile out(to);
  out.write(front.bytes);
  std::vector<std::byte> raw, wide;
  std::vector<std::vector<double>> values(additions.size());
  for (std::uint64_t first = 0; first < count; first += kPiecePoints) {
    const std::uint64_t n = std::min(kPiecePoints, count - first);
    raw.resize(n * header.record_length);
    in.read_at(header.points_offset + first * header.record_length, raw);
    wide.assign(n * stride, std::byte{0});
    for (auto& v : values) v.assign(n, 0.0);
    fill(first, values);
    for (std::uint64_t i = 0; i < n; ++i) {
      std::byte* record = wide.data() + i * stride;
      std::memcpy(record, raw.data() + i * header.record_length, header.record_length);
      for (std::size_t a = 0; a < additions.size(); ++a)
        store_value(record + places[a], values[a][i], additions[a], first + i);
    }
    out.write(wide);
  }
  for (std::uint64_t at = old_end; at < in.size(); at += kPiecePoints) {
    raw.resize(std::min<std::uint64_t>(kPiecePoints, in.size() - at));
    in.read_at(at, raw);
    out.write(raw);
  }
  out.close();
}

}  // namespace cairn::io
