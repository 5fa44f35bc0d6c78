#include <assimp/config.h>
#include <assimp/mesh.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <Eigen/LU>

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "base/number_text.hpp"
#include "io/assimp_mesh.hpp"
#include "io/bytes.hpp"
#include "io/glb.hpp"

namespace cairn::io {
namespace {

using geometry::Mat3;
using geometry::Vec3;

constexpr std::uint64_t kMaxBytes = std::uint64_t{1} << 30;
constexpr int kMaxNodeDepth = 64;
// A float keeps 24 bits: half a step of the largest coordinate.
constexpr double kFloatStep = 5.96e-8;
constexpr double kWorstRounding = 1e-3;  // m; more is worth a warning

// The one file in memory; any other is refused, so that a mesh cannot make us open files.
class MemoryStream : public Assimp::IOStream {
 public:
  explicit MemoryStream(Bytes bytes) : bytes_(bytes) {}
  size_t Read(void* to, size_t size, size_t count) override {
    if (size == 0) return 0;
    const std::size_t whole = std::min(count, (bytes_.size() - position_) / size);
    if (whole > 0) std::memcpy(to, bytes_.data() + position_, whole * size);
    position_ += whole * size;
    return whole;
  }
  size_t Write(const void* /*from*/, size_t /*size*/, size_t /*count*/) override { return 0; }
  aiReturn Seek(size_t offset, aiOrigin origin) override {
    const std::size_t base = origin == aiOrigin_CUR ? position_ : (origin == aiOrigin_END ? bytes_.size() : 0);
    if (origin == aiOrigin_END ? offset > base : offset > bytes_.size() - base) return aiReturn_FAILURE;
    position_ = origin == aiOrigin_END ? base - offset : base + offset;
    return aiReturn_SUCCESS;
  }
  [[nodiscard]] size_t Tell() const override { return position_; }
  [[nodiscard]] size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  Bytes bytes_;
  std::size_t position_ = 0;
};

class OneFile : public Assimp::IOSystem {
 public:
  OneFile(Bytes bytes, std::string name, std::vector<std::string>& refused)
      : bytes_(bytes), name_(std::move(name)), refused_(refused) {}
  bool Exists(const char* file) const override { return name_ == file; }
  [[nodiscard]] char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* /*mode*/) override {
    if (name_ == file) return new MemoryStream(bytes_);
    refused_.push_back(printable_text(std::as_bytes(std::span(file, std::strlen(file)))));
    return nullptr;
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  Bytes bytes_;
  std::string name_;
  std::vector<std::string>& refused_;
};

struct Affine {
  Mat3 linear = Mat3::Identity();
  Vec3 shift = Vec3::Zero();
};

Affine affine_of(const aiMatrix4x4& m) {
  Affine a;
  a.linear << static_cast<double>(m.a1), static_cast<double>(m.a2), static_cast<double>(m.a3),
      static_cast<double>(m.b1), static_cast<double>(m.b2), static_cast<double>(m.b3), static_cast<double>(m.c1),
      static_cast<double>(m.c2), static_cast<double>(m.c3);
  a.shift << static_cast<double>(m.a4), static_cast<double>(m.b4), static_cast<double>(m.c4);
  return a;
}

std::uint8_t byte_of(float value, bool linear) {
  double c = std::isfinite(value) ? std::clamp(static_cast<double>(value), 0.0, 1.0) : 0.0;
  if (linear) c = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(c * 255.0));
}

class Collector {
 public:
  Collector(const aiScene& scene, const std::string& file, bool y_up, bool linear_colours)
      : scene_(scene), file_(file), linear_colours_(linear_colours) {
    if (y_up) root_.linear << 1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0;
  }

  MeshData collect() {
    walk(*scene_.mRootNode, root_, 0);
    if (!all_coloured_) data_.mesh.colours.clear();
    return std::move(data_);
  }

 private:
  void walk(const aiNode& node, const Affine& parent, int depth) {
    if (depth > kMaxNodeDepth) throw bad_bytes(file_, 0, "the nodes of the mesh are nested too deeply");
    const Affine own = affine_of(node.mTransformation);
    const Affine world{parent.linear * own.linear, parent.linear * own.shift + parent.shift};
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
      if (node.mMeshes[i] < scene_.mNumMeshes) add(*scene_.mMeshes[node.mMeshes[i]], world);
    for (unsigned i = 0; i < node.mNumChildren; ++i) walk(*node.mChildren[i], world, depth + 1);
  }

  void add(const aiMesh& part, const Affine& world) {
    auto& mesh = data_.mesh;
    const std::size_t first = mesh.vertices.size();
    if (first + part.mNumVertices > std::numeric_limits<std::uint32_t>::max() - 1)
      throw bad_bytes(file_, 0, "too many vertices for a mesh");
    data_.facts.declared_points += part.mNumVertices;
    data_.facts.declared_faces += part.mNumFaces;
    const aiColor4D* colours = part.mColors[0];
    all_coloured_ = all_coloured_ && colours != nullptr;
    for (unsigned i = 0; i < part.mNumVertices; ++i) {
      const aiVector3D& v = part.mVertices[i];
      const Vec3 p(static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z));
      mesh.vertices.emplace_back(world.linear * p + world.shift);
      if (colours != nullptr)
        mesh.colours.push_back({byte_of(colours[i].r, linear_colours_), byte_of(colours[i].g, linear_colours_),
                                byte_of(colours[i].b, linear_colours_)});
    }
    // A transform that mirrors turns the triangles inside out.
    const bool mirrored = world.linear.determinant() < 0.0;
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) {
        ++data_.facts.dropped_faces;
        continue;
      }
      geometry::Triangle t{};
      for (unsigned k = 0; k < 3; ++k) {
        if (face.mIndices[k] >= part.mNumVertices)
          throw bad_bytes(file_, 0, "a face names a vertex that does not exist");
        t[k] = static_cast<std::uint32_t>(first + face.mIndices[k]);
      }
      if (mirrored) std::swap(t[1], t[2]);
      mesh.triangles.push_back(t);
    }
  }

  const aiScene& scene_;
  const std::string& file_;
  bool linear_colours_;
  Affine root_;
  MeshData data_;
  bool all_coloured_ = true;
};

// The origin that write_glb subtracted, where the file is one of ours.
Vec3 origin_of(const std::filesystem::path& path) {
  const Json document = read_glb_json(path);
  const Json* scenes = document.find("scenes");
  if (scenes == nullptr || !scenes->is_array() || scenes->size() != 1) return Vec3::Zero();
  const Json* extras = scenes->as_array()[0].find("extras");
  const Json* origin = extras != nullptr ? extras->find("origin_m") : nullptr;
  return origin != nullptr ? origin->as_vec3() : Vec3(Vec3::Zero());
}

void warn_rounding(MeshData& data) {
  double reach = 0.0;
  for (const auto& p : data.mesh.vertices) reach = std::max(reach, p.cwiseAbs().maxCoeff());
  if (std::isfinite(reach) && reach * kFloatStep > kWorstRounding)
    data.facts.warnings.push_back("coordinates up to " + base::to_fixed(reach, 0) +
                                  " in a single-precision file: rounded by up to " +
                                  base::to_fixed(reach * kFloatStep, 4) + " of a unit");
}

}  // namespace

MeshData read_assimp_mesh(const std::filesystem::path& path, std::string_view hint) {
  const FileBytes file(path);
  const std::string& name = file.name();
  if (file.bytes().size() > kMaxBytes)
    throw bad_bytes(name, 0, "the mesh file is too large for this format")
        .found(std::to_string(file.bytes().size()) + " bytes")
        .allowed("at most 1 GiB")
        .hint("Convert it to PLY");
  const bool y_up = hint == "glb" || hint == "gltf" || hint == "dae";
  std::vector<std::string> refused;
  try {
    Vec3 origin = Vec3::Zero();
    if (hint == "glb") origin = origin_of(path);
    Assimp::Importer importer;
    const std::string inside = "cairn." + std::string(hint);
    importer.SetIOHandler(new OneFile(file.bytes(), inside, refused));  // the importer owns it
    importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                                            aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS |
                                                            aiComponent_ANIMATIONS | aiComponent_TEXTURES |
                                                            aiComponent_LIGHTS | aiComponent_CAMERAS);
    const aiScene* scene = importer.ReadFile(inside, aiProcess_RemoveComponent | aiProcess_Triangulate);
    if (scene == nullptr || scene->mRootNode == nullptr) {
      auto error = bad_bytes(name, 0, "the mesh cannot be read: " + std::string(importer.GetErrorString()));
      if (!refused.empty())
        throw std::move(error)
            .found("a reference to '" + refused.front() + "'")
            .hint("Files outside are not opened: embed the buffers (GLB)");
      throw std::move(error).hint("The file is truncated or damaged");
    }
    MeshData data = Collector(*scene, name, y_up, hint == "glb" || hint == "gltf").collect();
    for (char c : hint) data.facts.format += static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
    if (hint == "gltf") data.facts.format = "glTF";
    data.facts.version = hint == "glb" || hint == "gltf" ? "2.0, read by assimp" : "read by assimp";
    if (!refused.empty())
      data.facts.warnings.push_back("files it refers to were not opened: " + refused.front() +
                                    (refused.size() > 1 ? " and others" : ""));
    if (data.facts.dropped_faces > 0)
      data.facts.warnings.push_back(std::to_string(data.facts.dropped_faces) + " points and lines were dropped");
    warn_rounding(data);
    for (auto& p : data.mesh.vertices) p += origin;
    drop_non_finite(data);
    if (hint == "stl") data.mesh = geometry::weld(data.mesh);
    return data;
  } catch (base::Error& error) {
    error.default_file(name);
    throw;
  } catch (const std::bad_alloc&) {
    throw bad_bytes(name, 0, "the mesh asks for more memory than there is");
  } catch (const std::exception& error) {
    throw bad_bytes(name, 0, "the mesh cannot be read: " + std::string(error.what()));
  }
}

}  // namespace cairn::io
