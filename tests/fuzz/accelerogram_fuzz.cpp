#include "io/accelerogram.hpp"

#include <cmath>

#include "fuzz/fuzz_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_file(data, size, [](const std::filesystem::path& path) {
    for (const auto& record : cairn::io::read_accelerograms(path, {"g", ""})) {
      if (!(record.dt_s > 0.0) || record.acceleration.size() < 2) std::abort();
      for (const double a : record.acceleration)
        if (!std::isfinite(a)) std::abort();
    }
  });
}
