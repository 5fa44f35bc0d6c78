// CRS records of LAS: GeoTIFF keys (1.0 to 1.3) and WKT (1.4).
#include <algorithm>
#include <utility>

#include "io/las_header.hpp"
#include "io/las_layout.hpp"

namespace cairn::io {

double las_unit_metres(int epsg_unit_code) {
  switch (epsg_unit_code) {
    case 9001: return 1.0;
    case 9002: return 0.3048;
    case 9003: return 1200.0 / 3937.0;
    default: return 0.0;
  }
}

namespace las {
namespace {

constexpr int kUserDefined = 32767;

// GeoTIFF keys that stand in the directory itself; text keys as a part of the text record.
struct GeoKeys {
  int model = 0, geographic = 0, projected = 0, linear_unit = 0, vertical = 0, vertical_unit = 0;
  std::string citation;
};

GeoKeys parse_keys(const LasRecord& directory, const std::string& text) {
  GeoKeys keys;
  const auto word = [&](std::size_t i) {
    return static_cast<int>(load_le<std::uint16_t>(directory.data.data() + 2 * i));
  };
  const std::size_t words = directory.data.size() / 2;
  if (words < 4) return keys;
  const auto count = std::min<std::size_t>(static_cast<std::size_t>(word(3)), (words - 4) / 4);
  for (std::size_t k = 0; k < count; ++k) {
    const int id = word(4 + 4 * k), location = word(5 + 4 * k), length = word(6 + 4 * k), value = word(7 + 4 * k);
    if (location == kGeoTextRecord && (id == 1026 || id == 3073) && static_cast<std::size_t>(value) < text.size()) {
      std::string part = text.substr(static_cast<std::size_t>(value), static_cast<std::size_t>(length));
      while (!part.empty() && (part.back() == '|' || part.back() == ' ')) part.pop_back();
      if (keys.citation.empty() || id == 3073) keys.citation = std::move(part);
    }
    if (location != 0) continue;
    switch (id) {
      case 1024: keys.model = value; break;
      case 2048: keys.geographic = value; break;
      case 3072: keys.projected = value; break;
      case 3076: keys.linear_unit = value; break;
      case 4096: keys.vertical = value; break;
      case 4099: keys.vertical_unit = value; break;
      default: break;
    }
  }
  return keys;
}

// GeoTIFF 1.0 wrote datum codes (5001 to 5206) where EPSG has CRS codes; the few in use are translated.
int vertical_crs(int code) {
  switch (code) {
    case 5101: return 5701;  // Newlyn -> ODN height
    case 5102: return 5702;  // NGVD29 (ftUS)
    case 5103: return 5703;  // NAVD88
    default: return code;
  }
}

bool is_code(int code) {
  return code > 0 && code < kUserDefined;
}

std::string text_of(const LasRecord& record) {
  std::vector<std::byte> bytes = record.data;
  for (std::byte& b : bytes)
    if (b == std::byte{'\n'} || b == std::byte{'\r'} || b == std::byte{'\t'}) b = std::byte{' '};
  return printable_text(bytes);
}

std::string crs_of(const GeoKeys& keys, int vertical) {
  const bool geographic = keys.model == 2 || !is_code(keys.projected);
  const int code = geographic && !is_code(keys.projected) ? keys.geographic : keys.projected;
  // A projected model that only names its geographic base is not that base.
  if (!is_code(code) || (keys.model == 1 && !is_code(keys.projected))) return "";
  std::string crs = "EPSG:" + std::to_string(code);
  const bool ellipsoidal = vertical >= 5001 && vertical < 5600;
  if (is_code(vertical) && !ellipsoidal) crs += "+" + std::to_string(vertical);
  return crs;
}

}  // namespace

std::vector<LasRecord> take_crs(std::vector<LasRecord> records, LasMetadata& m, std::vector<std::string>& warnings) {
  const LasRecord* directory = nullptr;
  std::string wkt, loose_wkt, key_text;
  std::vector<LasRecord> rest;
  std::vector<LasRecord> projection;
  for (auto& record : records) {
    if (record.user_id == kProjectionUser) projection.push_back(std::move(record));
    else if (record.user_id == "liblas" && record.record_id == kWktRecord) loose_wkt = text_of(record);
    else rest.push_back(std::move(record));
  }
  for (const auto& record : projection) {
    if (record.record_id == kGeoKeysRecord) directory = &record;
    if (record.record_id == kGeoTextRecord) key_text = text_of(record);
    if (record.record_id == kWktRecord) wkt = text_of(record);
  }
  const bool says_wkt = (m.global_encoding & 16U) != 0;
  if (directory != nullptr) {
    const GeoKeys keys = parse_keys(*directory, key_text);
    m.crs_citation = printable_text(std::as_bytes(std::span(keys.citation.data(), keys.citation.size())));
    m.linear_unit_code = keys.linear_unit;
    m.vertical_unit_code = keys.vertical_unit;
    m.vertical_crs_code = is_code(keys.vertical) ? vertical_crs(keys.vertical) : 0;
    m.crs = crs_of(keys, m.vertical_crs_code);
  }
  if (!wkt.empty() && wkt.find('[') == std::string::npos) {
    warnings.emplace_back("the WKT record holds no WKT text");
    wkt.clear();
  }
  // The WKT bit decides; without it WKT serves where the keys name no code.
  if (!wkt.empty() && (says_wkt || m.crs.empty())) m.crs = wkt;
  if (m.crs.empty() && !loose_wkt.empty()) m.crs = loose_wkt;
  if (says_wkt && wkt.empty() && directory != nullptr)
    warnings.emplace_back("the header announces a WKT coordinate reference system, but there is none");
  if (m.crs.empty() && directory != nullptr)
    warnings.emplace_back("the GeoTIFF keys name no EPSG code: the coordinate reference system is not known");
  if (m.point_format >= 6 && !says_wkt && m.crs.starts_with("EPSG:"))
    warnings.emplace_back(
        "the coordinate reference system is given by GeoTIFF keys, where this point format asks for WKT");
  return rest;
}

}  // namespace las
}  // namespace cairn::io
