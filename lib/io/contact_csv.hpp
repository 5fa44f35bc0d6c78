// contact.csv: digitised basal contacts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::io {

struct ContactRow {
  std::int64_t rock_id = 0;
  std::int64_t pad_id = 0;
  std::int64_t order = 0;
  geometry::Vec3 position = geometry::Vec3::Zero();  // in the CRS the header names
  bool observed = false;                             // status: observed or inferred
  double sigma_m = 0.0;                              // >= 0; 0 where the cell is empty
  bool closed = true;
};

struct ContactFile {
  std::string crs;               // of a header line "# crs: local" or "# crs: EPSG:n"; "" where none is declared
  std::vector<ContactRow> rows;  // in file order
};

// Columns rock_id,pad_id,order,x,y,z,status,sigma_m,closed. Throws invalid_input with line and column for an unknown
// status, a number that is not finite, a negative sigma, a repeated (rock, pad, order).
[[nodiscard]] ContactFile read_contact_csv(const std::filesystem::path& path);

}  // namespace cairn::io
