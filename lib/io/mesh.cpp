#include "io/mesh.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include "io/assimp_mesh.hpp"
#include "io/bytes.hpp"
#include "io/obj.hpp"
#include "io/ply.hpp"

namespace cairn::io {
namespace {

constexpr std::size_t kHeadBytes = 4096;
constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;
constexpr std::string_view kRead = "PLY, OBJ, STL, GLB, glTF, DAE or OFF";

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

}  // namespace

MeshFormat recognise_mesh(const std::filesystem::path& path) {
  const InputFile file(path);
  std::vector<std::byte> bytes(static_cast<std::size_t>(std::min<std::uint64_t>(file.size(), kHeadBytes)));
  file.read_at(0, bytes);
  const std::string_view head(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::string extension = extension_of(path);
  const auto refuse = [&](std::string message) { return bad_bytes(file.name(), 0, std::move(message)); };
  if (head.empty()) throw refuse("the file is empty").allowed(kRead);
  if (head.starts_with("ply") && head.size() > 3 && static_cast<unsigned char>(head[3]) <= ' ') return MeshFormat::ply;
  if (head.starts_with("glTF")) return MeshFormat::glb;
  if (head.starts_with("OFF") || head.starts_with("COFF")) return MeshFormat::off;
  if (head.find("<COLLADA") != std::string_view::npos) return MeshFormat::dae;
  if (extension == ".ply") return MeshFormat::ply;
  if (extension == ".obj") return MeshFormat::obj;
  if (extension == ".stl") return MeshFormat::stl;
  if (extension == ".glb") return MeshFormat::glb;
  if (extension == ".gltf") return MeshFormat::gltf;
  if (extension == ".dae") return MeshFormat::dae;
  if (extension == ".off") return MeshFormat::off;
  const bool stl_size =
      bytes.size() >= kStlHeader &&
      file.size() == kStlHeader + kStlTriangle * std::uint64_t{load_le<std::uint32_t>(bytes.data() + 80)};
  if (stl_size) return MeshFormat::stl;
  throw refuse("not a mesh that cairn reads").found("extension '" + extension + "'").allowed(kRead);
}

MeshData read_mesh(const std::filesystem::path& path) {
  const MeshFormat format = recognise_mesh(path);
  switch (format) {
    case MeshFormat::ply: return read_ply_mesh(path);
    case MeshFormat::obj: return read_obj_mesh(path);
    case MeshFormat::stl: return read_assimp_mesh(path, "stl");
    case MeshFormat::glb: return read_assimp_mesh(path, "glb");
    case MeshFormat::gltf: return read_assimp_mesh(path, "gltf");
    case MeshFormat::dae: return read_assimp_mesh(path, "dae");
    case MeshFormat::off: return read_assimp_mesh(path, "off");
  }
  return {};
}

void write_mesh(const std::filesystem::path& path, const geometry::TriangleMesh& mesh, const GlbWriteOptions& glb) {
  const std::string extension = extension_of(path);
  if (extension == ".ply") return write_ply(path, mesh);
  if (extension == ".obj") return write_obj(path, mesh);
  if (extension == ".glb") return write_glb(path, mesh, glb);
  throw base::Error(base::ErrorCode::invalid_argument, "cannot write a mesh in this format")
      .file(path.string())
      .found("extension '" + extension + "'")
      .allowed(".ply, .obj, .glb");
}

}  // namespace cairn::io
