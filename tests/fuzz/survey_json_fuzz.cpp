#include "fuzz/fuzz_text.hpp"
#include "io/survey_json.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  return cairn::testing::fuzz_text([&] {
    const auto json = cairn::io::parse_json(cairn::testing::as_text(data, size), "fuzz");
    const auto manifest = cairn::io::manifest_from_json(json, "fuzz");
    // What was accepted must survive being written.
    const auto text = cairn::io::to_json(manifest).dump();
    const auto again = cairn::io::manifest_from_json(cairn::io::parse_json(text, "again"), "again");
    if (cairn::io::to_json(again).dump() != text) std::abort();
  });
}
