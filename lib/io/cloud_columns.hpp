// Named columns of a table of points put where they belong in a point cloud. Shared by the readers of
// PLY, PCD and text; internal to io.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/point_cloud.hpp"
#include "io/bytes.hpp"

namespace cairn::io {

[[nodiscard]] std::size_t size_of(geometry::ScalarType type);

// Calls body with a value of the C++ type that stands for `type`.
template <typename Body>
auto with_type(geometry::ScalarType type, const Body& body) {
  using geometry::ScalarType;
  switch (type) {
    case ScalarType::u8: return body(std::uint8_t{});
    case ScalarType::i8: return body(std::int8_t{});
    case ScalarType::u16: return body(std::uint16_t{});
    case ScalarType::i16: return body(std::int16_t{});
    case ScalarType::u32: return body(std::uint32_t{});
    case ScalarType::i32: return body(std::int32_t{});
    case ScalarType::u64: return body(std::uint64_t{});
    case ScalarType::i64: return body(std::int64_t{});
    case ScalarType::f32: return body(float{});
    case ScalarType::f64: break;
  }
  return body(double{});
}

template <typename T>
[[nodiscard]] T load(const std::byte* from, bool swap) {
  return swap ? load_be<T>(from) : load_le<T>(from);
}

[[nodiscard]] inline double load_any(const std::byte* from, geometry::ScalarType type, bool swap) {
  return with_type(type, [&](auto kind) { return static_cast<double>(load<decltype(kind)>(from, swap)); });
}

// Where the values of one column go.
enum class Role { skip, position, normal, colour, packed_colour, intensity, classification, gps_time, scalar };

struct Slot {
  Role role = Role::skip;
  int axis = 0;            // of a position, normal or colour
  std::size_t scalar = 0;  // index among the cloud's scalars
  geometry::ScalarType type = geometry::ScalarType::f64;
};

struct NamedColumn {
  std::string name;
  geometry::ScalarType type = geometry::ScalarType::f64;
  bool skip = false;
};

// Decides by name, without regard to case. Normals and colours need all three of their parts, else they
// are scalars. positions_found: how many of x, y, z there are.
[[nodiscard]] std::vector<Slot> assign_slots(const std::vector<NamedColumn>& columns, int& positions_found);

// Sizes every column that a slot names to n points.
void make_columns(geometry::PointCloud& cloud, const std::vector<NamedColumn>& columns, std::vector<Slot>& slots,
                  std::size_t n);

// Value v of point i. Packed colours are put as their 32 bits.
void put_value(geometry::PointCloud& cloud, const Slot& slot, std::size_t i, double v);

}  // namespace cairn::io
