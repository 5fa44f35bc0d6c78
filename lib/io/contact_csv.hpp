// contact.csv: digitised basal contacts.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "survey/contact.hpp"

namespace cairn::io {

struct ContactRow {
  std::int64_t rock_id = 0;
  survey::ContactVertex vertex;  // in the CRS the header names; sigma 0 where the cell is empty
};

struct ContactFile {
  std::string crs;               // of a header line "# crs: local" or "# crs: EPSG:n"; "" where none is declared
  std::vector<ContactRow> rows;  // in file order
};

// Columns rock_id,pad_id,order,x,y,z,status,sigma_m,closed. Throws invalid_input with line and column for an unknown
// status, a number that is not finite, a negative sigma, a repeated (rock, pad, order).
[[nodiscard]] ContactFile read_contact_csv(const std::filesystem::path& path);

// Written straight to `path`; reads back bit for bit. Throws resource_exhausted where a write fails.
void write_contact_csv(const std::filesystem::path& path, const ContactFile& file);

}  // namespace cairn::io
