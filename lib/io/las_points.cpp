// Decoding of LAS point records.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "base/parallel.hpp"
#include "io/las_header.hpp"
#include "io/las_layout.hpp"

namespace cairn::io {
namespace {

using geometry::PointCloud;
using geometry::ScalarType;

// Pieces that stay in the second-level cache between the columns.
constexpr std::size_t kPieceBytes = std::size_t{1} << 18;

// One piece of raw records.
struct Piece {
  const std::byte* data;
  std::size_t stride, first, count;  // first: index in the cloud
};

template <typename T, typename Column, typename Convert>
void column(const Piece& piece, std::size_t offset, Column& values, const Convert& convert) {
  const std::byte* from = piece.data + offset;
  for (std::size_t i = 0; i < piece.count; ++i, from += piece.stride)
    values[piece.first + i] = convert(load_le<T>(from));
}

void positions(const Piece& piece, const LasMetadata& m, std::vector<geometry::Vec3>& out) {
  const double sx = m.scale.x(), sy = m.scale.y(), sz = m.scale.z();
  const double ox = m.offset.x(), oy = m.offset.y(), oz = m.offset.z();
  const std::byte* from = piece.data;
  geometry::Vec3* to = out.data() + piece.first;
  for (std::size_t i = 0; i < piece.count; ++i, from += piece.stride, ++to) {
    double* p = to->data();
    p[0] = static_cast<double>(load_le<std::int32_t>(from)) * sx + ox;
    p[1] = static_cast<double>(load_le<std::int32_t>(from + 4)) * sy + oy;
    p[2] = static_cast<double>(load_le<std::int32_t>(from + 8)) * sz + oz;
  }
}

template <typename T>
void scaled_column(const Piece& piece, std::size_t offset, const LasDimension& dimension, std::vector<double>& values,
                   std::atomic<std::uint64_t>& bad) {
  const double instead = dimension.no_data.value_or(las::kNoData);
  std::uint64_t local = 0;
  column<T>(piece, offset, values, [&](T raw) {
    const double value = static_cast<double>(raw) * dimension.scale + dimension.offset;
    if (std::isfinite(value)) return value;
    ++local;
    return instead;
  });
  bad += local;
}

void dimension_column(const Piece& piece, std::size_t offset, const LasDimension& dimension,
                      std::vector<double>& values, std::atomic<std::uint64_t>& bad) {
  switch (dimension.type) {
    case ScalarType::u8: return scaled_column<std::uint8_t>(piece, offset, dimension, values, bad);
    case ScalarType::i8: return scaled_column<std::int8_t>(piece, offset, dimension, values, bad);
    case ScalarType::u16: return scaled_column<std::uint16_t>(piece, offset, dimension, values, bad);
    case ScalarType::i16: return scaled_column<std::int16_t>(piece, offset, dimension, values, bad);
    case ScalarType::u32: return scaled_column<std::uint32_t>(piece, offset, dimension, values, bad);
    case ScalarType::i32: return scaled_column<std::int32_t>(piece, offset, dimension, values, bad);
    case ScalarType::u64: return scaled_column<std::uint64_t>(piece, offset, dimension, values, bad);
    case ScalarType::i64: return scaled_column<std::int64_t>(piece, offset, dimension, values, bad);
    case ScalarType::f32: return scaled_column<float>(piece, offset, dimension, values, bad);
    case ScalarType::f64: return scaled_column<double>(piece, offset, dimension, values, bad);
  }
}

std::string name_text(std::string_view name) {
  return std::string(name);
}

}  // namespace

struct LasReader::Impl {
  explicit Impl(const std::filesystem::path& path) : file(path) {
    header = las::read_header(file, facts.warnings);
    const LasMetadata& m = header.metadata;
    facts.format = "LAS";
    facts.version = "1." + std::to_string(m.minor_version) + ", point format " + std::to_string(m.point_format);
    facts.crs = m.crs;
    facts.horizontal_unit_m = las_unit_metres(m.linear_unit_code);
    facts.vertical_unit_m = las_unit_metres(m.vertical_unit_code);
    facts.declared_points = m.point_count;
  }
  InputFile file;
  las::Header header;
  SourceFacts facts;
};

LasReader::LasReader(const std::filesystem::path& path) : impl_(std::make_unique<Impl>(path)) {}
LasReader::~LasReader() = default;
LasReader::LasReader(LasReader&&) noexcept = default;
LasReader& LasReader::operator=(LasReader&&) noexcept = default;

const LasMetadata& LasReader::metadata() const noexcept {
  return impl_->header.metadata;
}
const SourceFacts& LasReader::facts() const noexcept {
  return impl_->facts;
}

PointCloud LasReader::read(std::uint64_t first, std::uint64_t count, const LasColumns& columns,
                           std::vector<std::string>* warnings) const {
  const las::Header& header = impl_->header;
  const LasMetadata& m = header.metadata;
  const las::PointLayout& layout = las::kLayouts[static_cast<std::size_t>(m.point_format)];
  first = std::min(first, m.point_count);
  const auto n = static_cast<std::size_t>(std::min(count, m.point_count - first));

  PointCloud cloud;
  cloud.positions.reserve(n);
  advise_large_pages(cloud.positions.data(), n * sizeof(geometry::Vec3));
  cloud.positions.resize(n);
  if (columns.intensity) cloud.intensity.resize(n);
  if (columns.classification) cloud.classification.resize(n);
  if (columns.colours && layout.rgb != 0) cloud.colours.resize(n);
  if (columns.gps_time && layout.gps_time != 0) cloud.gps_time.resize(n);
  std::size_t scalars = 0;
  const auto add = [&](std::string name, ScalarType type, std::string description) {
    cloud.scalars.push_back({std::move(name), type, std::move(description), std::vector<double>(n)});
    return scalars++;
  };
  std::size_t dimensions_at = 0, nir_at = 0, standard_at = 0;
  if (columns.dimensions) {
    dimensions_at = scalars;
    for (const auto& d : m.dimensions) add(d.name, d.scaled() ? ScalarType::f64 : d.type, d.description);
    if (layout.nir != 0) nir_at = add(name_text(las::kNearInfrared), ScalarType::u16, "near infrared");
  }
  if (columns.standard_fields) {
    standard_at = add(name_text(las::kReturnNumber), ScalarType::u8, "return number");
    add(name_text(las::kNumberOfReturns), ScalarType::u8, "number of returns of the pulse");
    add(name_text(las::kScanAngle), ScalarType::f32, "scan angle [deg]");
    add(name_text(las::kUserData), ScalarType::u8, "user data");
    add(name_text(las::kPointSourceId), ScalarType::u16, "point source id (flight line)");
  }

  std::atomic<std::uint64_t> bad_times{0}, withheld{0};
  std::vector<std::atomic<std::uint64_t>> bad_values(m.dimensions.size());
  const std::size_t stride = header.record_length;
  const std::size_t grain = std::max<std::size_t>(kPieceBytes / stride, 1);
  base::parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
    thread_local std::vector<std::byte> buffer;
    buffer.resize((end - begin) * stride);
    impl_->file.read_at(header.points_offset + (first + begin) * stride, buffer);
    const Piece piece{buffer.data(), stride, begin, end - begin};
    positions(piece, m, cloud.positions);
    if (!cloud.intensity.empty()) column<std::uint16_t>(piece, 12, cloud.intensity, [](std::uint16_t v) { return v; });
    if (!cloud.classification.empty()) {
      std::uint64_t flagged = 0;
      if (layout.extended) {
        column<std::uint8_t>(piece, layout.classification, cloud.classification, [](std::uint8_t v) { return v; });
        for (std::size_t i = 0; i < piece.count; ++i)
          flagged += std::to_integer<unsigned>(piece.data[i * stride + 15]) >> 2U & 1U;
      } else {
        column<std::uint8_t>(piece, layout.classification, cloud.classification, [&](std::uint8_t v) {
          flagged += static_cast<unsigned>(v) >> 7U;
          return static_cast<std::uint8_t>(v & 31U);
        });
      }
      withheld += flagged;
    }
    if (!cloud.colours.empty())
      for (std::size_t i = 0; i < piece.count; ++i) {
        const std::byte* from = piece.data + i * stride + layout.rgb;
        cloud.colours[begin + i] = {load_le<std::uint16_t>(from), load_le<std::uint16_t>(from + 2),
                                    load_le<std::uint16_t>(from + 4)};
      }
    if (!cloud.gps_time.empty()) {
      std::uint64_t bad = 0;
      column<double>(piece, layout.gps_time, cloud.gps_time, [&](double t) {
        if (std::isfinite(t)) return t;
        ++bad;
        return 0.0;
      });
      bad_times += bad;
    }
    if (columns.dimensions) {
      for (std::size_t d = 0; d < m.dimensions.size(); ++d)
        dimension_column(piece, header.dimension_offsets[d], m.dimensions[d], cloud.scalars[dimensions_at + d].values,
                         bad_values[d]);
      if (layout.nir != 0)
        column<std::uint16_t>(piece, layout.nir, cloud.scalars[nir_at].values,
                              [](std::uint16_t v) { return static_cast<double>(v); });
    }
    if (columns.standard_fields) {
      const unsigned bits = layout.extended ? 4U : 3U, mask = (1U << bits) - 1U;
      const auto values = [&](std::size_t k) -> std::vector<double>& { return cloud.scalars[standard_at + k].values; };
      column<std::uint8_t>(piece, 14, values(0),
                           [&](std::uint8_t v) { return static_cast<double>(static_cast<unsigned>(v) & mask); });
      column<std::uint8_t>(piece, 14, values(1), [&](std::uint8_t v) {
        return static_cast<double>(static_cast<unsigned>(v) >> bits & mask);
      });
      if (layout.extended)
        column<std::int16_t>(piece, layout.scan_angle, values(2),
                             [](std::int16_t v) { return static_cast<double>(v) * las::kScanAngleStepDeg; });
      else
        column<std::int8_t>(piece, layout.scan_angle, values(2), [](std::int8_t v) { return static_cast<double>(v); });
      column<std::uint8_t>(piece, layout.user_data, values(3), [](std::uint8_t v) { return static_cast<double>(v); });
      column<std::uint16_t>(piece, layout.source_id, values(4), [](std::uint16_t v) { return static_cast<double>(v); });
    }
  });

  if (warnings != nullptr) {
    if (bad_times != 0) warnings->push_back(std::to_string(bad_times) + " GPS times were not finite and are 0 now");
    for (std::size_t d = 0; d < bad_values.size(); ++d)
      if (bad_values[d] != 0)
        warnings->push_back(std::to_string(bad_values[d]) + " values of '" + m.dimensions[d].name +
                            "' were not finite and hold the no-data value now (-9999 where none is declared)");
    if (withheld != 0) warnings->push_back(std::to_string(withheld) + " points are flagged withheld and were kept");
  }
  return cloud;
}

LasCloud read_las(const std::filesystem::path& path, const LasColumns& columns) {
  const LasReader reader(path);
  LasCloud result{{}, reader.metadata(), reader.facts()};
  result.cloud = reader.read(0, reader.metadata().point_count, columns, &result.facts.warnings);
  // Some producers store 8-bit colours unscaled, against the specification.
  auto& colours = result.cloud.colours;
  const auto small = [](const auto& c) { return std::max({c[0], c[1], c[2]}) <= 255; };
  const auto black = [](const auto& c) { return std::max({c[0], c[1], c[2]}) == 0; };
  if (!std::all_of(colours.begin(), colours.end(), black) && std::all_of(colours.begin(), colours.end(), small)) {
    for (auto& c : colours)
      for (auto& v : c) v = static_cast<std::uint16_t>(v * 257);
    result.facts.warnings.emplace_back("colours are stored with 8 bits: scaled to 16");
  }
  return result;
}

}  // namespace cairn::io
