// LAS point clouds: our own reader (LAS 1.0 to 1.5, point formats 0 to 10) and writer (LAS 1.4
// formats 6 to 8, LAS 1.2 formats 0 to 3). Source: ASPRS, LAS Specification 1.4-R16 and 1.5.
//
// Not read: waveforms (skipped), LAZ and COPC (compressed; refused with a remedy).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "geometry/point_cloud.hpp"
#include "geometry/primitives.hpp"
#include "io/source_facts.hpp"

namespace cairn::io {

// A dimension of the extra bytes. Values in a cloud are raw * scale + offset.
struct LasDimension {
  std::string name, description;
  geometry::ScalarType type = geometry::ScalarType::f64;  // on disk
  double scale = 1.0, offset = 0.0;
  std::optional<double> no_data;  // as it appears in the cloud, after scale and offset

  [[nodiscard]] bool scaled() const { return scale != 1.0 || offset != 0.0; }
};

// A variable length record kept as it is.
struct LasRecord {
  std::string user_id;
  std::uint16_t record_id = 0;
  std::string description;
  std::vector<std::byte> data;
  bool extended = false;  // stored behind the points
};

// The header, its records, and what they say about the coordinate reference system.
struct LasMetadata {
  int minor_version = 4;  // LAS 1.x
  int point_format = 6;
  std::uint16_t file_source_id = 0;
  std::uint16_t global_encoding = 0;  // bit 0: GPS time is standard time - 1e9 s; bit 4: WKT
  std::array<std::byte, 16> guid{};
  std::string system_identifier, generating_software;
  std::uint16_t creation_day = 0, creation_year = 0;
  std::uint64_t point_count = 0;
  std::array<std::uint64_t, 15> points_by_return{};
  geometry::Vec3 scale = geometry::Vec3::Constant(1e-4);
  geometry::Vec3 offset = geometry::Vec3::Zero();
  geometry::Box3 bounds;  // as the header says, in file units

  // "EPSG:32615", "EPSG:2994+5703", a WKT text, or "" where none is declared (or only by keys
  // that name no EPSG code).
  std::string crs;
  int vertical_crs_code = 0;   // VerticalCSTypeGeoKey; 0 = none
  int linear_unit_code = 0;    // ProjLinearUnitsGeoKey (EPSG 9001 metre, 9002 foot, 9003 US survey foot); 0 = none
  int vertical_unit_code = 0;  // VerticalUnitsGeoKey; 0 = none
  std::string crs_citation;    // what the keys call it, for people
  std::vector<LasDimension> dimensions;
  std::vector<LasRecord> records;  // all but CRS and extra-bytes records
};

// Length in metres of a unit by its EPSG code (9001, 9002, 9003); 0 where unknown.
[[nodiscard]] double las_unit_metres(int epsg_unit_code);

// Which optional columns a read fills; positions always.
struct LasColumns {
  bool intensity = true;
  bool classification = true;
  bool colours = true;
  bool gps_time = true;
  bool dimensions = true;  // extra bytes, and near infrared as "nir"
  // return_number, number_of_returns, scan_angle_deg, user_data, point_source_id as scalar
  // columns of these names; write_las puts them back into their fields. 8 bytes a point each.
  bool standard_fields = false;

  [[nodiscard]] static LasColumns positions_only() { return {false, false, false, false, false, false}; }
};

// An open LAS file: the header is read and proved against the file's size on construction; points
// are read on demand, so that a large file can be taken in pieces. Reading is thread-safe.
class LasReader {
 public:
  // Throws not_found, or invalid_input with the offset of the first contradiction.
  explicit LasReader(const std::filesystem::path& path);
  ~LasReader();
  LasReader(LasReader&&) noexcept;
  LasReader& operator=(LasReader&&) noexcept;

  [[nodiscard]] const LasMetadata& metadata() const noexcept;
  [[nodiscard]] const SourceFacts& facts() const noexcept;

  // Points [first, first + count), clipped to the file. Coordinates are in the file's CRS and units.
  // GPS times that are not finite become 0, extra dimensions their no-data value or -9999; how many
  // is told in `warnings` where given. Colours are as stored. Cost: linear; about 9 ms CPU per million positions.
  [[nodiscard]] geometry::PointCloud read(std::uint64_t first, std::uint64_t count, const LasColumns& columns = {},
                                          std::vector<std::string>* warnings = nullptr) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

struct LasCloud {
  geometry::PointCloud cloud;
  LasMetadata metadata;
  SourceFacts facts;
};
// The whole file. A file with 0 points gives an empty cloud. Colours stored with 8 bits are scaled to 16.
[[nodiscard]] LasCloud read_las(const std::filesystem::path& path, const LasColumns& columns = {});

struct LasWriteOptions {
  // 4: LAS 1.4, format 6, 7 (colours) or 8 (colours and a "nir" column). 2: LAS 1.2, format 0 to 3.
  int minor_version = 4;
  // "EPSG:n" or WKT. LAS 1.4 needs WKT: where `crs` is an EPSG code, crs_wkt gives its text;
  // without it the code is written as GeoTIFF keys and the WKT bit stays clear.
  std::string crs;
  std::string crs_wkt;
  // Not given: 1e-4 (coarser where the extent needs it), and the centre of the cloud rounded
  // to whole units.
  std::optional<geometry::Vec3> scale, offset;
  // Of the file the cloud was read from: keeps identifiers, dates, GPS time kind, on-disk type and
  // scale of extra dimensions, and its other records. Scale and offset are taken from it
  // unless given above.
  const LasMetadata* source = nullptr;
};

// Writes straight to `path`. Positions are rounded to the scale. Throws invalid_argument where a
// position is not finite or does not fit the scale and offset, resource_exhausted where
// the disk fails. Columns: intensity, classification, colours, gps_time; scalars become extra
// dimensions (except the standard field names above); values that are not finite become -9999
// and are declared no-data (unsigned: 0); values that do not fit their type throw. Output depends on the arguments
// only.
void write_las(const std::filesystem::path& path, const geometry::PointCloud& cloud,
               const LasWriteOptions& options = {});

}  // namespace cairn::io
