#include "io/image_metadata.hpp"

#include <cmath>

#include "fuzz/fuzz_text.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_text([&] {
    const auto m = cairn::io::image_metadata_of(cairn::testing::as_text(data, size), "fuzz.jpg");
    if (m.latitude_deg && !(std::abs(*m.latitude_deg) <= 90.0)) std::abort();
    if (m.gps_altitude_m && !std::isfinite(*m.gps_altitude_m)) std::abort();
  });
}
