// A LAS file with more extra dimensions, copied piece by piece: for clouds that do not fit into memory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "geometry/point_cloud.hpp"

namespace cairn::io {

struct LasAddition {
  std::string name;  // at most 32 bytes; one the file has already, of the same type, is overwritten
  geometry::ScalarType type = geometry::ScalarType::f32;
  std::string description;  // at most 32 bytes
};

// Fills values[a][i] for addition a and point first + i; each vector comes with the length of the piece, zeros.
// Values are finite and fit their type.
using FillAdditions = std::function<void(std::uint64_t first, std::vector<std::vector<double>>& values)>;

// Everything else is copied as it stands: version, point format, coordinates, records (bytes between the records and
// the points, which no specification names, are dropped). Writes straight to `to`, which must not be `from`. Throws
// invalid_input where `from` is no sound LAS file, failed_precondition where it holds waveforms of its own or a
// dimension of the name but of another type, invalid_argument for values that do not fit.
// Cost linear; memory 64 K points.
void append_las_dimensions(const std::filesystem::path& from, const std::filesystem::path& to,
                           const std::vector<LasAddition>& additions, const FillAdditions& fill);

}  // namespace cairn::io
