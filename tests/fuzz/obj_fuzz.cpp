#include "io/obj.hpp"

#include "fuzz/fuzz_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_file(data, size, [](const std::filesystem::path& path) {
    const auto obj = cairn::io::read_obj_mesh(path);
    for (const auto& t : obj.mesh.triangles)
      for (const auto v : t)
        if (v >= obj.mesh.vertices.size()) std::abort();
    (void)cairn::io::read_obj_cloud(path);
  });
}
