#include "io/cloud_columns.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>

namespace cairn::io {
namespace {

using geometry::PointCloud;
using geometry::ScalarType;

std::uint16_t to_u16(double v, double scale) {
  return static_cast<std::uint16_t>(std::clamp(std::isfinite(v) ? std::round(v * scale) : 0.0, 0.0, 65535.0));
}

std::uint16_t colour_of(double v, ScalarType type) {
  switch (type) {
    case ScalarType::f32:
    case ScalarType::f64: return to_u16(v, 65535.0);
    case ScalarType::u16: return to_u16(v, 1.0);
    // "char" for a colour means the same byte.
    case ScalarType::i8: return to_u16(v < 0.0 ? v + 256.0 : v, 257.0);
    default: return to_u16(v, 257.0);
  }
}

int index_in(std::string_view name, std::initializer_list<std::string_view> names) {
  int i = 0;
  for (const auto& candidate : names) {
    if (candidate == name) return i;
    ++i;
  }
  return -1;
}

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace

std::size_t size_of(ScalarType type) {
  return with_type(type, [](auto kind) { return sizeof(kind); });
}

std::vector<Slot> assign_slots(const std::vector<NamedColumn>& columns, int& positions_found) {
  std::vector<Slot> slots(columns.size());
  // Bit k: axis k is there; a second column for it is a scalar.
  unsigned positions = 0, normals = 0, colours = 0;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    Slot& slot = slots[c];
    slot.type = columns[c].type;
    if (columns[c].skip) continue;
    slot.role = Role::scalar;
    const std::string name = lower(columns[c].name);
    const auto try_names = [&](Role role, std::initializer_list<std::string_view> names, unsigned& found) {
      const int axis = index_in(name, names);
      if (axis < 0 || (found >> static_cast<unsigned>(axis) & 1U) != 0) return;
      slot.role = role;
      slot.axis = axis;
      found |= 1U << static_cast<unsigned>(axis);
    };
    try_names(Role::position, {"x", "y", "z"}, positions);
    try_names(Role::normal, {"nx", "ny", "nz"}, normals);
    try_names(Role::normal, {"normal_x", "normal_y", "normal_z"}, normals);
    try_names(Role::colour, {"red", "green", "blue"}, colours);
    try_names(Role::colour, {"r", "g", "b"}, colours);
    try_names(Role::colour, {"diffuse_red", "diffuse_green", "diffuse_blue"}, colours);
    if (name == "intensity" && (slot.type == ScalarType::u8 || slot.type == ScalarType::u16))
      slot.role = Role::intensity;
    if (name == "classification" && slot.type == ScalarType::u8) slot.role = Role::classification;
    if ((name == "gps_time" || name == "gpstime") && slot.type == ScalarType::f64) slot.role = Role::gps_time;
    if ((name == "rgb" || name == "rgba") && size_of(slot.type) == 4) slot.role = Role::packed_colour;
  }
  positions_found = std::popcount(positions);
  for (Slot& slot : slots) {
    if (slot.role == Role::normal && normals != 7) slot.role = Role::scalar;
    if (slot.role == Role::colour && colours != 7) slot.role = Role::scalar;
    if (slot.role == Role::packed_colour && colours == 7) slot.role = Role::skip;
  }
  return slots;
}

void make_columns(PointCloud& cloud, const std::vector<NamedColumn>& columns, std::vector<Slot>& slots, std::size_t n) {
  cloud.positions.resize(n);
  for (std::size_t c = 0; c < slots.size(); ++c) {
    switch (slots[c].role) {
      case Role::normal: cloud.normals.resize(n); break;
      case Role::colour:
      case Role::packed_colour: cloud.colours.resize(n); break;
      case Role::intensity: cloud.intensity.resize(n); break;
      case Role::classification: cloud.classification.resize(n); break;
      case Role::gps_time: cloud.gps_time.resize(n); break;
      case Role::scalar:
        slots[c].scalar = cloud.scalars.size();
        cloud.scalars.push_back({columns[c].name, columns[c].type, "", std::vector<double>(n)});
        break;
      case Role::position:
      case Role::skip: break;
    }
  }
}

void put_value(PointCloud& cloud, const Slot& slot, std::size_t i, double v) {
  switch (slot.role) {
    case Role::position: cloud.positions[i][slot.axis] = v; break;
    case Role::normal: cloud.normals[i][slot.axis] = v; break;
    case Role::colour: cloud.colours[i][static_cast<std::size_t>(slot.axis)] = colour_of(v, slot.type); break;
    case Role::packed_colour: {
      const auto bits = static_cast<std::uint32_t>(std::clamp(v, 0.0, 4294967295.0));
      for (unsigned k = 0; k < 3; ++k)
        cloud.colours[i][k] = static_cast<std::uint16_t>((bits >> (16U - 8U * k) & 255U) * 257U);
      break;
    }
    case Role::intensity: cloud.intensity[i] = to_u16(v, 1.0); break;
    case Role::classification: cloud.classification[i] = static_cast<std::uint8_t>(to_u16(v, 1.0)); break;
    case Role::gps_time: cloud.gps_time[i] = v; break;
    case Role::scalar: cloud.scalars[slot.scalar].values[i] = v; break;
    case Role::skip: break;
  }
}

}  // namespace cairn::io
