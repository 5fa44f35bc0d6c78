#include "io/glb.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/version.hpp"
#include "io/bytes.hpp"

namespace cairn::io {
namespace {

using geometry::Vec3;

constexpr std::uint32_t kMagic = 0x46546C67;      // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedShort = 5123, kUnsignedInt = 5125;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;

using FloatVec = std::array<float, 3>;

// z-up to y-up: a rotation by -90 degrees about x.
FloatVec turned(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.z()), static_cast<float>(-p.y())};
}

// Vertex normals weighted by the angle of each corner (Thuermer and Wuethrich 1998); up where undefined.
std::vector<Vec3> vertex_normals(const geometry::TriangleMesh& mesh) {
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 area = mesh.area_vector(t);
    const double length = area.norm();
    if (!(length > 0.0)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh.vertices[mesh.triangles[t][k]];
      const Vec3 a = mesh.vertices[mesh.triangles[t][(k + 1) % 3]] - p;
      const Vec3 b = mesh.vertices[mesh.triangles[t][(k + 2) % 3]] - p;
      normals[mesh.triangles[t][k]] += area / length * std::atan2(a.cross(b).norm(), a.dot(b));
    }
  }
  for (Vec3& n : normals) {
    const double length = n.norm();
    n = length > 0.0 ? Vec3(n / length) : Vec3(Vec3::UnitZ());
  }
  return normals;
}

// glTF holds vertex colours in linear light; 8 bits would lose the dark ones.
std::uint16_t linear(std::uint8_t srgb) {
  const double c = srgb / 255.0;
  const double light = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  return static_cast<std::uint16_t>(std::lround(light * 65535.0));
}

Json numbers(const FloatVec& v) {
  return Json::Array{static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

}  // namespace

void write_glb(const std::filesystem::path& path, const geometry::TriangleMesh& mesh, const GlbWriteOptions& options) {
  const auto bad = [&](std::string message) {
    return base::Error(base::ErrorCode::invalid_argument, std::move(message)).file(path.string());
  };
  if (mesh.vertices.empty() || mesh.triangles.empty()) throw bad("a GLB file needs at least one triangle");
  const bool coloured = !mesh.colours.empty();
  if (coloured && mesh.colours.size() != mesh.vertices.size())
    throw bad("colours and vertices of the mesh differ in number");
  const std::uint64_t n = mesh.vertices.size(), corners = 3 * static_cast<std::uint64_t>(mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t)
      if (v >= n) throw bad("a triangle names a vertex that does not exist");

  std::vector<FloatVec> positions;
  positions.reserve(mesh.vertices.size());
  FloatVec lo, hi;
  lo.fill(std::numeric_limits<float>::infinity());
  hi.fill(-std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const FloatVec p = turned(mesh.vertices[i] - options.origin);
    for (std::size_t k = 0; k < 3; ++k) {
      if (!std::isfinite(p[k])) throw bad("a coordinate is not finite").record("vertex " + std::to_string(i));
      lo[k] = std::min(lo[k], p[k]);
      hi[k] = std::max(hi[k], p[k]);
    }
    positions.push_back(p);
  }

  Json views = Json::array(), accessors = Json::array(), attributes = Json::object();
  std::uint64_t length = 0;
  const auto add = [&](std::uint64_t bytes, int target, int stride, Json accessor) {
    Json view = Json::object({{"buffer", 0},
                              {"byteOffset", static_cast<std::int64_t>(length)},
                              {"byteLength", static_cast<std::int64_t>(bytes)}});
    if (stride > 0) view.set("byteStride", stride);
    view.set("target", target);
    accessor.set("bufferView", views.size());
    views.push(std::move(view));
    accessors.push(std::move(accessor));
    length += bytes;
    return static_cast<std::int64_t>(accessors.size()) - 1;
  };
  const auto count = static_cast<std::int64_t>(n);
  attributes.set("POSITION", add(12 * n, kArrayBuffer, 12,
                                 Json::object({{"componentType", kFloat},
                                               {"count", count},
                                               {"type", "VEC3"},
                                               {"min", numbers(lo)},
                                               {"max", numbers(hi)}})));
  if (options.normals)
    attributes.set("NORMAL", add(12 * n, kArrayBuffer, 12,
                                 Json::object({{"componentType", kFloat}, {"count", count}, {"type", "VEC3"}})));
  if (coloured)
    attributes.set(
        "COLOR_0",
        add(8 * n, kArrayBuffer, 8,
            Json::object(
                {{"componentType", kUnsignedShort}, {"normalized", true}, {"count", count}, {"type", "VEC4"}})));
  const std::int64_t indices =
      add(4 * corners, kElementArrayBuffer, 0,
          Json::object(
              {{"componentType", kUnsignedInt}, {"count", static_cast<std::int64_t>(corners)}, {"type", "SCALAR"}}));
  if (length > std::numeric_limits<std::uint32_t>::max() - (1U << 20U))
    throw bad("the mesh is too large for GLB").found(std::to_string(length) + " bytes").allowed("below 4 GiB");

  Json extras = Json::object({{"origin_m", Json(options.origin)},
                              {"frame", options.frame},
                              {"axes", "glTF y-up: x = east, y = up, z = south"}});
  if (options.properties.is_object())
    for (const auto& [key, value] : options.properties.as_object()) extras.set(key, value);
  Json factor = Json::Array{1.0, 1.0, 1.0, 1.0};
  if (!coloured) factor = Json::Array{options.base_colour[0], options.base_colour[1], options.base_colour[2], 1.0};
  const Json primitive = Json::object({{"attributes", attributes}, {"indices", indices}, {"material", 0}, {"mode", 4}});
  const Json material =
      Json::object({{"name", "surface"},
                    {"pbrMetallicRoughness",
                     Json::object({{"baseColorFactor", factor}, {"metallicFactor", 0.0}, {"roughnessFactor", 1.0}})},
                    {"doubleSided", true}});
  const Json document = Json::object(
      {{"asset", Json::object({{"version", "2.0"}, {"generator", "cairn " + std::string(base::kVersion)}})},
       {"scene", 0},
       {"scenes", Json::Array{Json::object({{"nodes", Json::Array{0}}, {"extras", extras}})}},
       {"nodes", Json::Array{Json::object({{"name", options.name}, {"mesh", 0}, {"extras", extras}})}},
       {"meshes", Json::Array{Json::object({{"name", options.name}, {"primitives", Json::Array{primitive}}})}},
       {"materials", Json::Array{material}},
       {"accessors", accessors},
       {"bufferViews", views},
       {"buffers", Json::Array{Json::object({{"byteLength", static_cast<std::int64_t>(length)}})}}});
  std::string text = document.dump(0);
  while (text.size() % 4 != 0) text += ' ';

  OutputFile out(path);
  out.put(kMagic);
  out.put(std::uint32_t{2});
  out.put(static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + length));
  out.put(static_cast<std::uint32_t>(text.size()));
  out.put(kJsonChunk);
  out.write(text);
  out.put(static_cast<std::uint32_t>(length));
  out.put(kBinaryChunk);
  for (const FloatVec& p : positions)
    for (const float v : p) out.put(v);
  if (options.normals)
    for (const Vec3& normal : vertex_normals(mesh))
      for (const float v : turned(normal)) out.put(v);
  if (coloured)
    for (const auto& c : mesh.colours) {
      for (const std::uint8_t v : c) out.put(linear(v));
      out.put(std::uint16_t{65535});
    }
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) out.put(v);
  out.close();
}

Json read_glb_json(const std::filesystem::path& path) {
  const InputFile file(path);
  std::byte head[20];
  if (file.size() < sizeof(head)) throw bad_bytes(file.name(), file.size(), "the file is too short for GLB");
  file.read_at(0, head);
  if (load_le<std::uint32_t>(head) != kMagic) throw bad_bytes(file.name(), 0, "not a GLB file").allowed("'glTF'");
  if (load_le<std::uint32_t>(head + 4) != 2)
    throw bad_bytes(file.name(), 4, "unknown glTF version")
        .found(std::to_string(load_le<std::uint32_t>(head + 4)))
        .allowed("2");
  const std::uint64_t size = load_le<std::uint32_t>(head + 12);
  if (load_le<std::uint32_t>(head + 16) != kJsonChunk || size > file.size() - sizeof(head))
    throw bad_bytes(file.name(), 12, "the first chunk is not JSON that fits the file")
        .found(std::to_string(size) + " bytes")
        .allowed("at most " + std::to_string(file.size() - sizeof(head)))
        .hint("The file is truncated");
  std::vector<std::byte> text(static_cast<std::size_t>(size));
  file.read_at(sizeof(head), text);
  return parse_json({reinterpret_cast<const char*>(text.data()), text.size()}, file.name());
}

}  // namespace cairn::io
