#include "io/ply.hpp"

#include "fuzz/fuzz_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_file(data, size, [](const std::filesystem::path& path) {
    const auto cloud = cairn::io::read_ply_cloud(path);
    if (!cloud.cloud.consistent()) std::abort();
    const auto mesh = cairn::io::read_ply_mesh(path);
    for (const auto& t : mesh.mesh.triangles)
      for (const auto v : t)
        if (v >= mesh.mesh.vertices.size()) std::abort();
  });
}
