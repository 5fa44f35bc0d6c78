#include "io/xyz.hpp"

#include "fuzz/fuzz_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_file(data, size, [](const std::filesystem::path& path) {
    if (!cairn::io::read_xyz(path).cloud.consistent()) std::abort();
  });
}
