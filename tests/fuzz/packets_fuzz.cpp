#include <variant>

#include "fuzz/fuzz_file.hpp"
#include "io/packets.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span(data, size));
  const auto decoded = cairn::io::try_decode(bytes);
  if (const auto* packet = std::get_if<cairn::survey::Packet>(&decoded)) {
    const auto again = cairn::io::encode(*packet);
    if (!std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) std::abort();
  }
  return cairn::testing::fuzz_file(data, size, [](const std::filesystem::path& path) {
    for (const auto& received : cairn::io::read_packet_log(path).packets)
      for (const auto& object : received.packet.objects)
        if (!object.position.allFinite()) std::abort();
    static_cast<void>(cairn::io::read_packets(path));
  });
}
