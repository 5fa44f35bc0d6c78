// What write_las decides before the first byte is written. Internal to the LAS part.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <vector>

#include "io/las.hpp"
#include "io/las_layout.hpp"

namespace cairn::io::las {

using geometry::ScalarColumn;

template <typename T>
void store(std::byte* to, T value) {
  std::memcpy(to, &value, sizeof(T));
}

[[nodiscard]] inline double raw_of(double value, double scale, double offset) {
  return std::round((value - offset) / scale);
}

// One extra dimension and where its values come from.
struct OutDimension {
  LasDimension facts;
  const ScalarColumn* column = nullptr;
  std::size_t offset = 0;
};

// Everything the header and the records need, decided before the first byte is written.
struct Plan {
  int minor = 4, format = 6;
  PointLayout layout;
  std::size_t stride = 0;
  geometry::Vec3 scale, offset;
  geometry::Box3 bounds;
  const ScalarColumn* return_number = nullptr;
  const ScalarColumn* number_of_returns = nullptr;
  const ScalarColumn* scan_angle = nullptr;
  const ScalarColumn* user_data = nullptr;
  const ScalarColumn* source_id = nullptr;
  const ScalarColumn* nir = nullptr;
  std::vector<OutDimension> dimensions;
  std::vector<LasRecord> records;
  std::uint16_t encoding = 0;
  std::array<std::uint64_t, 15> by_return{};
};

[[nodiscard]] inline bool is_real(geometry::ScalarType type) {
  return type == geometry::ScalarType::f32 || type == geometry::ScalarType::f64;
}

// What goes on disk for a value; finite and within the type once make_plan has returned.
[[nodiscard]] double raw_value(const OutDimension& dimension, double value);

// Checks every value and chooses format, scale, offset and records. Throws invalid_argument.
[[nodiscard]] Plan make_plan(const std::filesystem::path& path, const geometry::PointCloud& cloud,
                             const LasWriteOptions& options);

}  // namespace cairn::io::las
