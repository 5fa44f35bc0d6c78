#include "io/pcd.hpp"

#include "fuzz/fuzz_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  return cairn::testing::fuzz_file(bytes, size, [](const std::filesystem::path& path) {
    const auto data = cairn::io::read_pcd(path);
    if (!data.cloud.consistent()) std::abort();
    for (const auto& p : data.cloud.positions)
      if (!p.allFinite()) std::abort();
  });
}
