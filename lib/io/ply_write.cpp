// Writing of binary little-endian PLY.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "io/bytes.hpp"
#include "io/ply.hpp"

namespace cairn::io {
namespace {

using geometry::ScalarType;

base::Error bad_argument(const std::filesystem::path& path, std::string message) {
  return base::Error(base::ErrorCode::invalid_argument, std::move(message)).file(path.string());
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r') c = ' ';
  return text;
}

// Property names are single words.
std::string one_word(std::string text) {
  for (char& c : text)
    if (c <= ' ' || c > '~') c = '_';
  return text.empty() ? "_" : text;
}

std::string begin_header(const PlyWriteOptions& options) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const auto& comment : options.comments) header += "comment " + one_line(comment) + "\n";
  if (!options.crs.empty()) header += "comment crs " + one_line(options.crs) + "\n";
  return header;
}

std::string_view type_name(ScalarType type) {
  switch (type) {
    case ScalarType::u8: return "uchar";
    case ScalarType::i8: return "char";
    case ScalarType::u16: return "ushort";
    case ScalarType::i16: return "short";
    case ScalarType::u32: return "uint";
    case ScalarType::i32: return "int";
    case ScalarType::f32: return "float";
    // PLY 1.0 has no 64-bit integers.
    case ScalarType::u64:
    case ScalarType::i64:
    case ScalarType::f64: return "double";
  }
  return "double";
}

template <typename T>
T within(double v) {
  constexpr auto kLo = static_cast<double>(std::numeric_limits<T>::lowest());
  constexpr auto kHi = static_cast<double>(std::numeric_limits<T>::max());
  return static_cast<T>(std::clamp(std::round(v), kLo, kHi));
}

void put_scalar(OutputFile& out, ScalarType type, double v) {
  if (!std::isfinite(v)) v = kNoDataValue;
  switch (type) {
    case ScalarType::u8: return out.put(within<std::uint8_t>(v));
    case ScalarType::i8: return out.put(within<std::int8_t>(v));
    case ScalarType::u16: return out.put(within<std::uint16_t>(v));
    case ScalarType::i16: return out.put(within<std::int16_t>(v));
    case ScalarType::u32: return out.put(within<std::uint32_t>(v));
    case ScalarType::i32: return out.put(within<std::int32_t>(v));
    case ScalarType::f32:
      return out.put(static_cast<float>(std::clamp(v, -3.4028234663852886e38, 3.4028234663852886e38)));
    case ScalarType::u64:
    case ScalarType::i64:
    case ScalarType::f64: return out.put(v);
  }
}

void put_position(OutputFile& out, const std::filesystem::path& path, const geometry::Vec3& p, std::size_t i) {
  if (!p.allFinite()) throw bad_argument(path, "a coordinate is not finite").record("point " + std::to_string(i));
  for (int axis = 0; axis < 3; ++axis) out.put(p[axis]);
}

constexpr std::string_view kPosition = "property double x\nproperty double y\nproperty double z\n";
constexpr std::string_view kColour = "property uchar red\nproperty uchar green\nproperty uchar blue\n";

}  // namespace

void write_ply(const std::filesystem::path& path, const geometry::PointCloud& cloud, const PlyWriteOptions& options) {
  if (!cloud.consistent()) throw bad_argument(path, "the columns of the cloud differ in length");
  std::string header = begin_header(options);
  header += "element vertex " + std::to_string(cloud.size()) + "\n";
  header += kPosition;
  if (!cloud.normals.empty()) header += "property float nx\nproperty float ny\nproperty float nz\n";
  if (!cloud.colours.empty()) header += kColour;
  if (!cloud.intensity.empty()) header += "property ushort intensity\n";
  if (!cloud.classification.empty()) header += "property uchar classification\n";
  if (!cloud.gps_time.empty()) header += "property double gps_time\n";
  for (const auto& column : cloud.scalars)
    header += "property " + std::string(type_name(column.type)) + " " + one_word(column.name) + "\n";
  header += "end_header\n";
  OutputFile out(path);
  out.write(header);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    put_position(out, path, cloud.positions[i], i);
    if (!cloud.normals.empty())
      for (int axis = 0; axis < 3; ++axis) {
        const double n = cloud.normals[i][axis];
        out.put(std::isfinite(n) ? static_cast<float>(n) : 0.0F);
      }
    if (!cloud.colours.empty())
      for (const std::uint16_t c : cloud.colours[i]) out.put(static_cast<std::uint8_t>(c >> 8U));
    if (!cloud.intensity.empty()) out.put(cloud.intensity[i]);
    if (!cloud.classification.empty()) out.put(cloud.classification[i]);
    if (!cloud.gps_time.empty()) out.put(std::isfinite(cloud.gps_time[i]) ? cloud.gps_time[i] : 0.0);
    for (const auto& column : cloud.scalars) put_scalar(out, column.type, column.values[i]);
  }
  out.close();
}

void write_ply(const std::filesystem::path& path, const geometry::TriangleMesh& mesh, const PlyWriteOptions& options) {
  const bool coloured = !mesh.colours.empty();
  if (coloured && mesh.colours.size() != mesh.vertices.size())
    throw bad_argument(path, "colours and vertices of the mesh differ in number");
  std::string header = begin_header(options);
  header += "element vertex " + std::to_string(mesh.vertices.size()) + "\n";
  header += kPosition;
  if (coloured) header += kColour;
  header += "element face " + std::to_string(mesh.triangles.size()) + "\n";
  header += "property list uchar uint vertex_indices\nend_header\n";
  OutputFile out(path);
  out.write(header);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    put_position(out, path, mesh.vertices[i], i);
    if (coloured)
      for (const std::uint8_t c : mesh.colours[i]) out.put(c);
  }
  for (const auto& t : mesh.triangles) {
    out.put(std::uint8_t{3});
    for (const std::uint32_t v : t) {
      if (v >= mesh.vertices.size()) throw bad_argument(path, "a triangle names a vertex that does not exist");
      out.put(v);
    }
  }
  out.close();
}

}  // namespace cairn::io
