#include "io/las_header.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "base/number_text.hpp"
#include "io/las_layout.hpp"

namespace cairn::io::las {
namespace {

constexpr std::uint64_t kHeaderBytes12 = 227, kHeaderBytes13 = 235, kHeaderBytes14 = 375;
constexpr std::uint64_t kRecordHeader = 54, kExtendedRecordHeader = 60;

std::uint64_t least_header(int minor) {
  if (minor >= 4) return kHeaderBytes14;
  return minor == 3 ? kHeaderBytes13 : kHeaderBytes12;
}

LasRecord read_record(const InputFile& file, std::uint64_t& offset, bool extended) {
  const std::uint64_t head_size = extended ? kExtendedRecordHeader : kRecordHeader;
  std::byte head[kExtendedRecordHeader];
  file.read_at(offset, {head, static_cast<std::size_t>(head_size)});
  ByteReader in({head, static_cast<std::size_t>(head_size)}, file.name(), offset);
  LasRecord record;
  record.extended = extended;
  in.skip(2, "a record header");
  record.user_id = printable_text(in.bytes(16, "a record header"));
  record.record_id = in.read<std::uint16_t>("a record header");
  const std::uint64_t length = extended ? in.read<std::uint64_t>("a record header") : in.read<std::uint16_t>("");
  record.description = printable_text(in.bytes(32, "a record header"));
  const std::uint64_t data_offset = offset + head_size;
  if (length > file.size() - data_offset)
    throw bad_bytes(file.name(), offset + 20, "a variable length record runs past the end of the file")
        .found(std::to_string(length) + " bytes")
        .allowed("at most " + std::to_string(file.size() - data_offset))
        .hint("The file is truncated or its header is wrong");
  record.data.resize(static_cast<std::size_t>(length));
  file.read_at(data_offset, record.data);
  offset = data_offset + length;
  return record;
}

double any_type(const std::byte* from, geometry::ScalarType type) {
  switch (type) {
    case geometry::ScalarType::u8:
    case geometry::ScalarType::u16:
    case geometry::ScalarType::u32:
    case geometry::ScalarType::u64: return static_cast<double>(load_le<std::uint64_t>(from));
    case geometry::ScalarType::i8:
    case geometry::ScalarType::i16:
    case geometry::ScalarType::i32:
    case geometry::ScalarType::i64: return static_cast<double>(load_le<std::int64_t>(from));
    case geometry::ScalarType::f32:
    case geometry::ScalarType::f64: return load_le<double>(from);
  }
  return 0.0;
}

// LAS 1.4-R16 table 25: what the bytes behind the standard fields hold.
void read_dimensions(const LasRecord& record, const InputFile& file, std::uint32_t record_length, Header& header,
                     std::vector<std::string>& warnings) {
  std::uint32_t offset = kLayouts[static_cast<std::size_t>(header.metadata.point_format)].length;
  std::set<std::string> names;
  for (std::size_t d = 0; (d + 1) * kExtraBytesDescriptor <= record.data.size(); ++d) {
    const std::byte* from = record.data.data() + d * kExtraBytesDescriptor;
    const int code = std::to_integer<int>(from[2]);
    const unsigned options = std::to_integer<unsigned>(from[3]);
    const std::string name = printable_text({from + 4, 32});
    // Codes 11 to 30 are arrays of two and three, deprecated since 1.4-R14.
    const int parts = code == 0 ? 0 : (code - 1) / 10 + 1;
    std::uint32_t width = options;  // undocumented bytes
    if (code > 0 && code <= 30) {
      const geometry::ScalarType type = kExtraTypes[static_cast<std::size_t>((code - 1) % 10)];
      width = static_cast<std::uint32_t>(size_of(type)) * static_cast<std::uint32_t>(parts);
      if (offset + width > record_length) {
        throw base::Error(base::ErrorCode::invalid_input,
                          "extra dimension '" + name + "' lies outside the point record")
            .file(file.name())
            .record("extra dimension " + std::to_string(d + 1))
            .found("bytes " + std::to_string(offset) + " to " + std::to_string(offset + width))
            .allowed("up to " + std::to_string(record_length))
            .hint("The record that describes extra bytes does not fit the point record length");
      }
      for (int part = 0; part < parts; ++part) {
        const auto at = [&](std::size_t base) { return from + base + 8 * static_cast<std::size_t>(part); };
        LasDimension dimension;
        dimension.name = name.empty() ? "extra_" + std::to_string(d + 1) : name;
        if (parts > 1) dimension.name += "_" + std::to_string(part);
        dimension.description = printable_text({from + 160, 32});
        dimension.type = type;
        if ((options & 8U) != 0) dimension.scale = load_le<double>(at(112));
        if ((options & 16U) != 0) dimension.offset = load_le<double>(at(136));
        if (!std::isfinite(dimension.scale) || !std::isfinite(dimension.offset) || dimension.scale == 0.0) {
          warnings.push_back("extra dimension '" + dimension.name + "' has no usable scale and offset: taken unscaled");
          dimension.scale = 1.0;
          dimension.offset = 0.0;
        }
        if ((options & 1U) != 0) {
          const double no_data = any_type(at(40), type) * dimension.scale + dimension.offset;
          if (std::isfinite(no_data)) dimension.no_data = no_data;
        }
        if (!names.insert(dimension.name).second) {
          dimension.name += "_" + std::to_string(d + 1) + "_" + std::to_string(part);
          names.insert(dimension.name);
        }
        header.metadata.dimensions.push_back(std::move(dimension));
        header.dimension_offsets.push_back(offset + static_cast<std::uint32_t>(size_of(type)) *
                                                        static_cast<std::uint32_t>(part));
      }
    } else if (code > 30) {
      warnings.push_back("extra dimension '" + name + "' has the unknown type " + std::to_string(code) +
                         ": it and those behind it are not read");
      return;
    }
    offset += width;
  }
  if (offset < record_length)
    warnings.push_back(std::to_string(record_length - offset) + " bytes of each point record are not described");
}

// Scaled coordinates of any 32-bit integer must be finite, so that no point needs a test of its own.
void check_scale(const InputFile& file, const LasMetadata& m) {
  constexpr double kMaxRaw = 2147483648.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double reach = std::abs(m.scale[axis]) * kMaxRaw + std::abs(m.offset[axis]);
    if (m.scale[axis] == 0.0 || !std::isfinite(reach))
      throw bad_bytes(file.name(), static_cast<std::uint64_t>(131 + 8 * axis),
                      std::string("unusable scale or offset of axis ") + "xyz"[axis])
          .found("scale " + base::to_text(m.scale[axis]) + ", offset " + base::to_text(m.offset[axis]))
          .allowed("finite numbers, scale not 0");
  }
}

}  // namespace

Header read_header(const InputFile& file, std::vector<std::string>& warnings) {
  std::vector<std::byte> block(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), kHeaderBytes14)));
  file.read_at(0, block);
  ByteReader in(block, file.name());
  const Bytes magic = in.bytes(4, "the signature");
  if (printable_text(magic) != "LASF")
    throw bad_bytes(file.name(), 0, "not a LAS file").found("'" + printable_text(magic) + "'").allowed("'LASF'");
  Header header;
  LasMetadata& m = header.metadata;
  m.file_source_id = in.read<std::uint16_t>("the header");
  m.global_encoding = in.read<std::uint16_t>("the header");
  std::ranges::copy(in.bytes(16, "the header"), m.guid.begin());
  const int major = in.read<std::uint8_t>("the header");
  m.minor_version = in.read<std::uint8_t>("the header");
  if (major != 1 || m.minor_version > 5)
    throw bad_bytes(file.name(), 24, "unknown LAS version")
        .found(std::to_string(major) + "." + std::to_string(m.minor_version))
        .allowed("1.0 to 1.5");
  m.system_identifier = printable_text(in.bytes(32, "the header"));
  m.generating_software = printable_text(in.bytes(32, "the header"));
  m.creation_day = in.read<std::uint16_t>("the header");
  m.creation_year = in.read<std::uint16_t>("the header");
  const std::uint64_t header_size = in.read<std::uint16_t>("the header");
  header.points_offset = in.read<std::uint32_t>("the header");
  const std::uint32_t record_count = in.read<std::uint32_t>("the header");
  const unsigned format = in.read<std::uint8_t>("the header");
  header.record_length = in.read<std::uint16_t>("the header");
  const std::uint64_t legacy_count = in.read<std::uint32_t>("the header");
  for (std::size_t i = 0; i < 5; ++i) m.points_by_return[i] = in.read<std::uint32_t>("the header");
  for (int i = 0; i < 3; ++i) m.scale[i] = in.read<double>("the header");
  for (int i = 0; i < 3; ++i) m.offset[i] = in.read<double>("the header");
  for (int i = 0; i < 3; ++i) {
    m.bounds.max[i] = in.read<double>("the header");
    m.bounds.min[i] = in.read<double>("the header");
  }
  if (header_size < least_header(m.minor_version))
    throw bad_bytes(file.name(), 94, "the header is too short for its version")
        .found(std::to_string(header_size) + " bytes")
        .allowed("at least " + std::to_string(least_header(m.minor_version)) + " in LAS 1." +
                 std::to_string(m.minor_version));
  if ((format & 0xC0U) != 0)
    throw bad_bytes(file.name(), 104, "the points are compressed (LAZ), which cairn does not read")
        .found("point format " + std::to_string(format))
        .allowed("0 to 10")
        .hint("Decompress it first, for example with 'laszip -i in.laz -o out.las' or 'pdal translate in.laz out.las'");
  if (format >= kPointFormats)
    throw bad_bytes(file.name(), 104, "unknown point format").found(std::to_string(format)).allowed("0 to 10");
  m.point_format = static_cast<int>(format);
  const PointLayout& layout = kLayouts[format];
  if (header.record_length < layout.length)
    throw bad_bytes(file.name(), 105, "the point record is too short for its format")
        .found(std::to_string(header.record_length) + " bytes")
        .allowed("at least " + std::to_string(layout.length) + " in format " + std::to_string(format));
  if (header.points_offset < header_size || header.points_offset > file.size())
    throw bad_bytes(file.name(), 96, "the points start outside the file")
        .found("byte " + std::to_string(header.points_offset))
        .allowed(std::to_string(header_size) + " to " + std::to_string(file.size()))
        .hint("The file is truncated or its header is wrong");
  check_scale(file, m);

  m.point_count = legacy_count;
  std::uint64_t extended_start = 0;
  std::uint32_t extended_count = 0;
  if (m.minor_version >= 3) in.skip(8, "the header");
  if (m.minor_version >= 4) {
    extended_start = in.read<std::uint64_t>("the header");
    extended_count = in.read<std::uint32_t>("the header");
    const std::uint64_t count = in.read<std::uint64_t>("the header");
    std::array<std::uint64_t, 15> by_return{};
    for (auto& n : by_return) n = in.read<std::uint64_t>("the header");
    if (count != 0 || legacy_count == 0) {
      if (legacy_count != 0 && legacy_count != count)
        warnings.push_back("the 32-bit point count (" + std::to_string(legacy_count) +
                           ") differs from the 64-bit one (" + std::to_string(count) + "), which is taken");
      m.point_count = count;
      m.points_by_return = by_return;
    } else {
      warnings.push_back("the 64-bit point count is 0: the 32-bit one (" + std::to_string(legacy_count) + ") is taken");
    }
  }
  const std::uint64_t room = (file.size() - header.points_offset) / header.record_length;
  if (m.point_count > room)
    throw bad_bytes(file.name(), m.minor_version >= 4 && m.point_count != legacy_count ? 247 : 107,
                    "the header promises more points than the file holds")
        .found(std::to_string(m.point_count) + " points of " + std::to_string(header.record_length) + " bytes")
        .allowed("at most " + std::to_string(room) + " in the " + std::to_string(file.size() - header.points_offset) +
                 " bytes behind byte " + std::to_string(header.points_offset))
        .hint("The file is truncated: copy it again from its source");
  const std::uint64_t points_end = header.points_offset + m.point_count * header.record_length;

  std::vector<LasRecord> records;
  std::uint64_t offset = header_size;
  if (record_count > (header.points_offset - header_size) / kRecordHeader)
    throw bad_bytes(file.name(), 100, "more variable length records than fit before the points")
        .found(std::to_string(record_count))
        .allowed("at most " + std::to_string((header.points_offset - header_size) / kRecordHeader));
  for (std::uint32_t i = 0; i < record_count; ++i) {
    if (offset + kRecordHeader > header.points_offset)
      throw bad_bytes(file.name(), offset, "variable length record " + std::to_string(i + 1) + " runs into the points")
          .found("points at byte " + std::to_string(header.points_offset));
    records.push_back(read_record(file, offset, false));
    if (offset > header.points_offset)
      throw bad_bytes(file.name(), offset, "variable length record " + std::to_string(i + 1) + " runs into the points")
          .found("points at byte " + std::to_string(header.points_offset));
  }
  if (extended_count != 0) {
    if (extended_start < points_end || extended_start > file.size() ||
        extended_count > (file.size() - extended_start) / kExtendedRecordHeader)
      throw bad_bytes(file.name(), 235, "extended variable length records outside the file")
          .found(std::to_string(extended_count) + " at byte " + std::to_string(extended_start))
          .allowed("byte " + std::to_string(points_end) + " to " + std::to_string(file.size()));
    offset = extended_start;
    for (std::uint32_t i = 0; i < extended_count; ++i) records.push_back(read_record(file, offset, true));
  }
  bool described = false;
  std::vector<LasRecord> kept;
  for (auto& record : take_crs(std::move(records), m, warnings)) {
    if (record.user_id == kSpecUser && record.record_id == kExtraBytesRecord) {
      if (!described) read_dimensions(record, file, header.record_length, header, warnings);
      described = true;
    } else {
      kept.push_back(std::move(record));
    }
  }
  m.records = std::move(kept);
  if (!described && header.record_length > layout.length)
    warnings.push_back(std::to_string(header.record_length - layout.length) +
                       " bytes of each point record are not described");
  return header;
}

}  // namespace cairn::io::las
