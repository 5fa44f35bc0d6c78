// Checks and choices of the LAS writer.
#include "io/las_plan.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "base/number_text.hpp"
#include "io/bytes.hpp"

namespace cairn::io::las {
namespace {

using geometry::PointCloud;
using geometry::ScalarType;
using geometry::Vec3;

constexpr double kRawReach = 2147483647.0;
constexpr double kDefaultScale = 1e-4;
constexpr std::size_t kShortRecord = 65535;

base::Error bad_argument(const std::filesystem::path& path, std::string message) {
  return base::Error(base::ErrorCode::invalid_argument, std::move(message)).file(path.string());
}

struct Limits {
  double lo, hi;
};
Limits limits_of(ScalarType type) {
  switch (type) {
    case ScalarType::u8: return {0.0, 255.0};
    case ScalarType::i8: return {-128.0, 127.0};
    case ScalarType::u16: return {0.0, 65535.0};
    case ScalarType::i16: return {-32768.0, 32767.0};
    case ScalarType::u32: return {0.0, 4294967295.0};
    case ScalarType::i32: return {-2147483648.0, 2147483647.0};
    // Largest doubles below 2^64 and 2^63.
    case ScalarType::u64: return {0.0, 18446744073709549568.0};
    case ScalarType::i64: return {-9223372036854775808.0, 9223372036854774784.0};
    case ScalarType::f32: return {-3.4028234663852886e38, 3.4028234663852886e38};
    case ScalarType::f64: return {std::numeric_limits<double>::lowest(), std::numeric_limits<double>::max()};
  }
  return {0.0, 0.0};
}

double default_no_data(ScalarType type) {
  const Limits limits = limits_of(type);
  return limits.lo == 0.0 ? 0.0 : std::max(limits.lo, kNoData);
}

void check_dimension(const std::filesystem::path& path, OutDimension& d) {
  const Limits limits = limits_of(d.facts.type);
  if (!d.facts.no_data &&
      std::any_of(d.column->values.begin(), d.column->values.end(), [](double v) { return !std::isfinite(v); }))
    d.facts.no_data = default_no_data(d.facts.type);
  for (std::size_t i = 0; i < d.column->values.size(); ++i) {
    const double raw = raw_value(d, d.column->values[i]);
    if (!(raw >= limits.lo && raw <= limits.hi))
      throw bad_argument(path, "a value of '" + d.facts.name + "' does not fit its type")
          .record("point " + std::to_string(i))
          .found(base::to_text(d.column->values[i]))
          .allowed(base::to_text(limits.lo) + " to " + base::to_text(limits.hi));
  }
}

std::vector<std::byte> bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  std::vector<std::byte> data(bytes.begin(), bytes.end());
  data.push_back(std::byte{0});
  return data;
}

// Directory of GeoTIFF keys for "EPSG:h" or "EPSG:h+v"; empty where the text is no such code.
std::vector<std::byte> geo_keys(std::string_view crs) {
  if (!crs.starts_with("EPSG:")) return {};
  crs.remove_prefix(5);
  const std::size_t plus = crs.find('+');
  const auto horizontal = base::parse_integer(crs.substr(0, plus));
  const auto vertical =
      plus == std::string_view::npos ? std::optional<std::int64_t>(0) : base::parse_integer(crs.substr(plus + 1));
  if (!horizontal || !vertical || *horizontal < 1 || *horizontal > 32766 || *vertical < 0 || *vertical > 32766)
    return {};
  // Codes of geographic systems lie at 4000 to 4999 (and some newer ones above 6300).
  const bool geographic = (*horizontal >= 4000 && *horizontal < 5000) || *horizontal == 6318 || *horizontal == 7844;
  std::vector<std::uint16_t> words = {1, 1, 0, 0};
  const auto key = [&](std::uint16_t id, std::int64_t value) {
    words.insert(words.end(), {id, 0, 1, static_cast<std::uint16_t>(value)});
    ++words[3];
  };
  key(1024, geographic ? 2 : 1);
  key(1025, 1);
  key(geographic ? 2048 : 3072, *horizontal);
  if (*vertical != 0) key(4096, *vertical);
  std::vector<std::byte> data(words.size() * 2);
  std::memcpy(data.data(), words.data(), data.size());
  return data;
}

bool kept_record(const LasRecord& record) {
  const bool waveform = record.user_id == kSpecUser && record.record_id >= 100;
  return !waveform && record.user_id != "laszip encoded" && record.user_id != "copc";
}

void plan_records(const std::filesystem::path& path, const LasWriteOptions& options, Plan& plan) {
  const auto projection = [&](std::uint16_t id, std::string description, std::vector<std::byte> data) {
    plan.records.push_back({std::string(kProjectionUser), id, std::move(description), std::move(data), false});
  };
  const bool is_wkt = !options.crs.empty() && options.crs.find('[') != std::string::npos;
  const std::string& wkt = is_wkt ? options.crs : options.crs_wkt;
  const auto keys = geo_keys(options.crs);
  bool wkt_bit = plan.format >= 6;
  if (!wkt.empty() && (plan.minor >= 4 || keys.empty())) {
    projection(kWktRecord, "OGC WKT", bytes_of(wkt));
    wkt_bit = plan.minor >= 4;
  } else if (!keys.empty()) {
    projection(kGeoKeysRecord, "GeoTIFF keys", keys);
    wkt_bit = false;
  } else if (!options.crs.empty()) {
    throw bad_argument(path, "cannot put this coordinate reference system into a LAS file")
        .found(options.crs)
        .allowed("'EPSG:n', 'EPSG:n+m' or WKT");
  }
  if (wkt_bit) plan.encoding |= 16U;
  if (!plan.dimensions.empty()) {
    LasRecord record{std::string(kSpecUser), kExtraBytesRecord, "extra bytes", {}, false};
    record.data.resize(plan.dimensions.size() * kExtraBytesDescriptor);
    for (std::size_t i = 0; i < plan.dimensions.size(); ++i) {
      const LasDimension& d = plan.dimensions[i].facts;
      std::byte* to = record.data.data() + i * kExtraBytesDescriptor;
      const auto type = std::ranges::find(kExtraTypes, d.type) - kExtraTypes.begin();
      unsigned flags = d.scaled() ? 24U : 0U;
      std::memcpy(to + 4, d.name.data(), std::min<std::size_t>(d.name.size(), 32));
      if (d.no_data) {
        flags |= 1U;
        const double raw = raw_value(plan.dimensions[i], *d.no_data);
        if (is_real(d.type)) store(to + 40, raw);
        else if (limits_of(d.type).lo == 0.0) store(to + 40, static_cast<std::uint64_t>(raw));
        else store(to + 40, static_cast<std::int64_t>(raw));
      }
      if (d.scaled()) {
        store(to + 112, d.scale);
        store(to + 136, d.offset);
      }
      std::memcpy(to + 160, d.description.data(), std::min<std::size_t>(d.description.size(), 32));
      to[2] = static_cast<std::byte>(type + 1);
      to[3] = static_cast<std::byte>(flags);
    }
    plan.records.push_back(std::move(record));
  }
  if (options.source != nullptr)
    for (LasRecord record : options.source->records) {
      if (!kept_record(record)) continue;
      if (plan.minor < 4) record.extended = false;
      if (record.extended || record.data.size() <= kShortRecord) plan.records.push_back(std::move(record));
    }
  for (const auto& record : plan.records)
    if (!record.extended && record.data.size() > kShortRecord)
      throw bad_argument(path, "a LAS record is too long: " + record.description)
          .found(std::to_string(record.data.size()) + " bytes")
          .allowed("at most 65535");
}

void plan_scale(const std::filesystem::path& path, const PointCloud& cloud, const LasWriteOptions& options,
                Plan& plan) {
  geometry::Box3 box;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.positions[i].allFinite())
      throw bad_argument(path, "a position is not finite").record("point " + std::to_string(i));
    box.extend(cloud.positions[i]);
  }
  if (cloud.empty()) box.extend(Vec3::Zero());
  for (int axis = 0; axis < 3; ++axis) {
    const auto fits = [&](double scale, double offset) {
      return std::abs(raw_of(box.min[axis], scale, offset)) <= kRawReach &&
             std::abs(raw_of(box.max[axis], scale, offset)) <= kRawReach;
    };
    double& scale = plan.scale[axis];
    double& offset = plan.offset[axis];
    const double centre = std::round(0.5 * box.min[axis] + 0.5 * box.max[axis]);
    scale = options.scale ? (*options.scale)[axis]
                          : (options.source != nullptr ? options.source->scale[axis] : kDefaultScale);
    if (!(scale > 0.0) || !std::isfinite(scale))
      throw bad_argument(path, "the scale must be positive").found(base::to_text(scale));
    if (options.offset) offset = (*options.offset)[axis];
    else if (options.source != nullptr && fits(scale, options.source->offset[axis]))
      offset = options.source->offset[axis];
    else offset = centre;
    if (!options.scale)
      while (!fits(scale, offset) && scale < 1e300) scale *= 10.0;
    if (!std::isfinite(offset) || !fits(scale, offset))
      throw bad_argument(path, std::string("the cloud does not fit the scale and offset of axis ") + "xyz"[axis])
          .found(base::to_text(box.min[axis]) + " to " + base::to_text(box.max[axis]) + " with scale " +
                 base::to_text(scale) + " and offset " + base::to_text(offset))
          .hint("Give a coarser scale or an offset near the data");
    plan.bounds.min[axis] = raw_of(box.min[axis], scale, offset) * scale + offset;
    plan.bounds.max[axis] = raw_of(box.max[axis], scale, offset) * scale + offset;
  }
  if (cloud.empty()) plan.bounds.min = plan.bounds.max = Vec3::Zero();
}

void check_range(const std::filesystem::path& path, const ScalarColumn* column, double lo, double hi) {
  if (column == nullptr) return;
  for (std::size_t i = 0; i < column->values.size(); ++i)
    if (!(column->values[i] >= lo && column->values[i] <= hi))
      throw bad_argument(path, "a value of '" + column->name + "' does not fit its LAS field")
          .record("point " + std::to_string(i))
          .found(base::to_text(column->values[i]))
          .allowed(base::to_text(lo) + " to " + base::to_text(hi));
}

}  // namespace

double raw_value(const OutDimension& d, double value) {
  if (!std::isfinite(value)) value = *d.facts.no_data;
  const double raw = d.facts.scaled() ? (value - d.facts.offset) / d.facts.scale : value;
  return is_real(d.facts.type) ? raw : std::round(raw);
}

Plan make_plan(const std::filesystem::path& path, const PointCloud& cloud, const LasWriteOptions& options) {
  if (!cloud.consistent()) throw bad_argument(path, "the columns of the cloud differ in length");
  if (options.minor_version != 2 && options.minor_version != 4)
    throw bad_argument(path, "LAS 1." + std::to_string(options.minor_version) + " is not written").allowed("2, 4");
  Plan plan;
  plan.minor = options.minor_version;
  for (const auto& column : cloud.scalars) {
    if (column.name == kReturnNumber) plan.return_number = &column;
    else if (column.name == kNumberOfReturns) plan.number_of_returns = &column;
    else if (column.name == kScanAngle) plan.scan_angle = &column;
    else if (column.name == kUserData) plan.user_data = &column;
    else if (column.name == kPointSourceId) plan.source_id = &column;
    else if (column.name == kNearInfrared && plan.minor >= 4) plan.nir = &column;
    else {
      OutDimension d{{column.name, column.description, column.type, 1.0, 0.0, std::nullopt}, &column, 0};
      if (options.source != nullptr)
        for (const auto& known : options.source->dimensions)
          if (known.name == column.name) d.facts = known;
      check_dimension(path, d);
      plan.dimensions.push_back(std::move(d));
    }
  }
  const bool colours = !cloud.colours.empty();
  if (plan.minor >= 4) plan.format = plan.nir != nullptr ? 8 : (colours ? 7 : 6);
  else plan.format = (colours ? 2 : 0) + (cloud.gps_time.empty() ? 0 : 1);
  plan.layout = kLayouts[static_cast<std::size_t>(plan.format)];
  plan.stride = plan.layout.length;
  for (auto& d : plan.dimensions) {
    d.offset = plan.stride;
    plan.stride += size_of(d.facts.type);
  }
  if (plan.stride > kShortRecord) throw bad_argument(path, "too many extra dimensions for one LAS record");
  const double returns = plan.layout.extended ? 15.0 : 7.0;
  check_range(path, plan.return_number, 0.0, returns);
  check_range(path, plan.number_of_returns, 0.0, returns);
  check_range(path, plan.scan_angle, plan.layout.extended ? -180.0 : -128.0, plan.layout.extended ? 180.0 : 127.0);
  check_range(path, plan.user_data, 0.0, 255.0);
  check_range(path, plan.source_id, 0.0, 65535.0);
  check_range(path, plan.nir, 0.0, 65535.0);
  if (!plan.layout.extended)
    for (std::size_t i = 0; i < cloud.classification.size(); ++i)
      if (cloud.classification[i] > 31)
        throw bad_argument(path, "LAS 1.2 holds classes 0 to 31 only")
            .record("point " + std::to_string(i))
            .found(std::to_string(cloud.classification[i]))
            .hint("Write LAS 1.4");
  for (std::size_t i = 0; i < cloud.gps_time.size(); ++i)
    if (!std::isfinite(cloud.gps_time[i]))
      throw bad_argument(path, "a GPS time is not finite").record("point " + std::to_string(i));
  plan_scale(path, cloud, options, plan);
  if (options.source != nullptr) plan.encoding = options.source->global_encoding & 1U;
  plan_records(path, options, plan);
  if (plan.return_number == nullptr) plan.by_return[0] = cloud.size();
  else
    for (const double r : plan.return_number->values)
      if (r >= 1.0) ++plan.by_return[static_cast<std::size_t>(r) - 1];
  if (plan.minor < 4 && cloud.size() > std::numeric_limits<std::uint32_t>::max())
    throw bad_argument(path, "LAS 1.2 holds at most 4294967295 points").hint("Write LAS 1.4");
  return plan;
}

}  // namespace cairn::io::las
