// The public header block of a LAS file and its records. Internal to the LAS part.
#pragma once

#include <cstdint>
#include <vector>

#include "io/bytes.hpp"
#include "io/las.hpp"

namespace cairn::io::las {

struct Header {
  LasMetadata metadata;
  std::uint64_t points_offset = 0;
  std::uint32_t record_length = 0;
  std::vector<std::uint32_t> dimension_offsets;  // in the record, parallel to metadata.dimensions
};

// Reads and checks all that stands before and behind the points. Nothing is reserved that the
// file's size does not justify.
[[nodiscard]] Header read_header(const InputFile& file, std::vector<std::string>& warnings);

// Fills the CRS fields of `metadata` from the projection records, and returns the other records.
[[nodiscard]] std::vector<LasRecord> take_crs(std::vector<LasRecord> records, LasMetadata& metadata,
                                              std::vector<std::string>& warnings);

}  // namespace cairn::io::las
