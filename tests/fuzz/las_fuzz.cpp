#include "io/las.hpp"

#include "fuzz/fuzz_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_file(data, size, [](const std::filesystem::path& path) {
    cairn::io::LasColumns columns;
    columns.standard_fields = true;
    const auto las = cairn::io::read_las(path, columns);
    if (!las.cloud.consistent()) std::abort();
    for (const auto& p : las.cloud.positions)
      if (!p.allFinite()) std::abort();
  });
}
