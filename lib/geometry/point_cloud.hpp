// A point cloud: double positions and optional columns of equal length.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/vec.hpp"

namespace cairn::geometry {

// An added per-point column with a name (LAS extra dimension, PLY property).
// The on-disk type is kept so that a file written back holds the same type.
enum class ScalarType { u8, i8, u16, i16, u32, i32, u64, i64, f32, f64 };

struct ScalarColumn {
  std::string name;  // "target_id"
  ScalarType type = ScalarType::f64;
  std::string description;     // free text, "" if none; units belong here: "height above ground [m]"
  std::vector<double> values;  // same length as the positions; integers are exact up to 2^53
};

// Columns other than positions are empty, or exactly as long as positions.
struct PointCloud {
  std::vector<Vec3> positions;                        // m, in the frame the owner names (local ENU inside cairn)
  std::vector<std::array<std::uint16_t, 3>> colours;  // red, green, blue, 0..65535
  std::vector<Vec3> normals;                          // unit
  std::vector<std::uint16_t> intensity;
  std::vector<std::uint8_t> classification;  // ASPRS codes: 1 unassigned, 2 ground
  std::vector<double> gps_time;              // s, as in the file
  std::vector<ScalarColumn> scalars;

  [[nodiscard]] std::size_t size() const { return positions.size(); }
  [[nodiscard]] bool empty() const { return positions.empty(); }
  // Column by name, or nullptr.
  [[nodiscard]] const ScalarColumn* scalar(const std::string& name) const;
  // New column of size() zeros (replaces one of that name); the reference lives until the next call.
  ScalarColumn& add_scalar(std::string name, ScalarType type, std::string description);
  // Every column empty or of size(): what readers and writers assert.
  [[nodiscard]] bool consistent() const;
  // The points at the given indices, in that order, with all columns. Indices < size().
  [[nodiscard]] PointCloud subset(const std::vector<std::size_t>& indices) const;
};

}  // namespace cairn::geometry
