#include "fuzz/fuzz_text.hpp"
#include "io/colmap.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_text([&] {
    const auto [cameras, images, points] = cairn::testing::three_files(data, size);
    const auto model = cairn::io::parse_colmap_text({cameras, images, points, "fuzz"});
    for (const auto& image : model.images)
      if (!image.T_world_camera.translation.allFinite() || !image.T_world_camera.rotation.allFinite()) std::abort();
  });
}
