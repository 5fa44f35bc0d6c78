// Writing of LAS 1.4 and 1.2.
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "base/parallel.hpp"
#include "base/version.hpp"
#include "io/bytes.hpp"
#include "io/las.hpp"
#include "io/las_layout.hpp"
#include "io/las_plan.hpp"

namespace cairn::io {
namespace {

using geometry::PointCloud;
using geometry::ScalarColumn;
using geometry::ScalarType;
using las::Plan;
using las::raw_of;
using las::raw_value;
using las::store;

constexpr std::size_t kSlabBytes = std::size_t{1} << 24;
constexpr std::size_t kPiecePoints = 8192;

void store_raw(std::byte* to, ScalarType type, double raw) {
  switch (type) {
    case ScalarType::u8: return store(to, static_cast<std::uint8_t>(raw));
    case ScalarType::i8: return store(to, static_cast<std::int8_t>(raw));
    case ScalarType::u16: return store(to, static_cast<std::uint16_t>(raw));
    case ScalarType::i16: return store(to, static_cast<std::int16_t>(raw));
    case ScalarType::u32: return store(to, static_cast<std::uint32_t>(raw));
    case ScalarType::i32: return store(to, static_cast<std::int32_t>(raw));
    case ScalarType::u64: return store(to, static_cast<std::uint64_t>(raw));
    case ScalarType::i64: return store(to, static_cast<std::int64_t>(raw));
    case ScalarType::f32: return store(to, static_cast<float>(raw));
    case ScalarType::f64: return store(to, raw);
  }
}

void encode(const Plan& plan, const PointCloud& cloud, std::size_t i, std::byte* to) {
  for (int axis = 0; axis < 3; ++axis)
    store(to + 4 * axis,
          static_cast<std::int32_t>(raw_of(cloud.positions[i][axis], plan.scale[axis], plan.offset[axis])));
  if (!cloud.intensity.empty()) store(to + 12, cloud.intensity[i]);
  const auto of = [i](const ScalarColumn* column, double otherwise) {
    return column == nullptr ? otherwise : column->values[i];
  };
  const auto number = static_cast<unsigned>(of(plan.return_number, 1.0));
  const auto returns = static_cast<unsigned>(of(plan.number_of_returns, std::max(1.0, of(plan.return_number, 1.0))));
  to[14] = static_cast<std::byte>(number | returns << (plan.layout.extended ? 4U : 3U));
  // 0, "never classified", where the cloud has no classes.
  if (!cloud.classification.empty()) to[plan.layout.classification] = static_cast<std::byte>(cloud.classification[i]);
  to[plan.layout.user_data] = static_cast<std::byte>(static_cast<unsigned>(of(plan.user_data, 0.0)));
  const double angle = of(plan.scan_angle, 0.0);
  if (plan.layout.extended)
    store(to + plan.layout.scan_angle, static_cast<std::int16_t>(std::lround(angle / las::kScanAngleStepDeg)));
  else store(to + plan.layout.scan_angle, static_cast<std::int8_t>(std::lround(angle)));
  store(to + plan.layout.source_id, static_cast<std::uint16_t>(of(plan.source_id, 0.0)));
  if (plan.layout.gps_time != 0 && !cloud.gps_time.empty()) store(to + plan.layout.gps_time, cloud.gps_time[i]);
  if (plan.layout.rgb != 0 && !cloud.colours.empty()) std::memcpy(to + plan.layout.rgb, cloud.colours[i].data(), 6);
  if (plan.layout.nir != 0) store(to + plan.layout.nir, static_cast<std::uint16_t>(of(plan.nir, 0.0)));
  for (const auto& d : plan.dimensions) store_raw(to + d.offset, d.facts.type, raw_value(d, d.column->values[i]));
}

void write_records(OutputFile& out, const Plan& plan, bool extended) {
  for (const auto& record : plan.records) {
    if (record.extended != extended) continue;
    out.put(std::uint16_t{0});
    out.put_text(record.user_id, 16);
    out.put(record.record_id);
    if (extended) out.put(static_cast<std::uint64_t>(record.data.size()));
    else out.put(static_cast<std::uint16_t>(record.data.size()));
    out.put_text(record.description, 32);
    out.write(record.data);
  }
}

void write_header(OutputFile& out, const Plan& plan, const PointCloud& cloud, const LasMetadata* source) {
  const std::uint16_t header_size = plan.minor >= 4 ? 375 : 227;
  std::uint64_t points_offset = header_size;
  std::uint32_t short_records = 0, long_records = 0;
  for (const auto& record : plan.records) {
    if (record.extended) {
      ++long_records;
    } else {
      ++short_records;
      points_offset += 54 + record.data.size();
    }
  }
  if (points_offset > std::numeric_limits<std::uint32_t>::max())
    throw base::Error(base::ErrorCode::invalid_argument, "the LAS records are too long");
  const std::uint64_t count = cloud.size();
  out.write(std::string_view("LASF"));
  out.put(source != nullptr ? source->file_source_id : std::uint16_t{0});
  out.put(plan.encoding);
  out.write(source != nullptr ? Bytes(source->guid) : Bytes(std::array<std::byte, 16>{}));
  out.put(std::uint8_t{1});
  out.put(static_cast<std::uint8_t>(plan.minor));
  out.put_text(source != nullptr ? source->system_identifier : "OTHER", 32);
  out.put_text(std::string("cairn ") + std::string(base::kVersion), 32);
  out.put(source != nullptr ? source->creation_day : std::uint16_t{0});
  out.put(source != nullptr ? source->creation_year : std::uint16_t{0});
  out.put(header_size);
  out.put(static_cast<std::uint32_t>(points_offset));
  out.put(short_records);
  out.put(static_cast<std::uint8_t>(plan.format));
  out.put(static_cast<std::uint16_t>(plan.stride));
  // Formats 6 to 10 have no legacy counts.
  const bool legacy = plan.format < 6;
  out.put(static_cast<std::uint32_t>(legacy ? count : 0));
  for (std::size_t i = 0; i < 5; ++i) out.put(static_cast<std::uint32_t>(legacy ? plan.by_return[i] : 0));
  for (int i = 0; i < 3; ++i) out.put(plan.scale[i]);
  for (int i = 0; i < 3; ++i) out.put(plan.offset[i]);
  for (int i = 0; i < 3; ++i) {
    out.put(plan.bounds.max[i]);
    out.put(plan.bounds.min[i]);
  }
  if (plan.minor < 4) return;
  out.put(std::uint64_t{0});
  out.put(long_records > 0 ? points_offset + count * plan.stride : std::uint64_t{0});
  out.put(long_records);
  out.put(count);
  for (const std::uint64_t n : plan.by_return) out.put(n);
}

}  // namespace

void write_las(const std::filesystem::path& path, const PointCloud& cloud, const LasWriteOptions& options) {
  const Plan plan = las::make_plan(path, cloud, options);
  OutputFile out(path);
  write_header(out, plan, cloud, options.source);
  write_records(out, plan, false);
  const std::size_t slab_points = std::max<std::size_t>(kSlabBytes / plan.stride, 1);
  std::vector<std::byte> slab;
  for (std::size_t first = 0; first < cloud.size(); first += slab_points) {
    const std::size_t n = std::min(slab_points, cloud.size() - first);
    slab.assign(n * plan.stride, std::byte{0});
    base::parallel_for(n, kPiecePoints, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) encode(plan, cloud, first + i, slab.data() + i * plan.stride);
    });
    out.write(slab);
  }
  write_records(out, plan, true);
  out.close();
}

}  // namespace cairn::io
