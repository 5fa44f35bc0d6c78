// What the packet codec and the recordings share.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

namespace cairn::io {

inline constexpr std::size_t kPacketHeaderBytes = 32;
inline constexpr std::size_t kChecksumBytes = 4;
inline constexpr std::size_t kMinPacketBytes = kPacketHeaderBytes + kChecksumBytes;

// CRC-32 of IEEE 802.3 (reflected, polynomial 0x04C11DB7), as in PNG and gzip; "123456789" gives 0xCBF43926.
[[nodiscard]] std::uint32_t packet_checksum(std::span<const std::byte> bytes);

template <typename T>
void append_le(std::vector<std::byte>& out, T value) {
  static_assert(std::is_arithmetic_v<T>);
  const auto bytes = std::as_bytes(std::span(&value, 1));
  out.insert(out.end(), bytes.begin(), bytes.end());
}

}  // namespace cairn::io
