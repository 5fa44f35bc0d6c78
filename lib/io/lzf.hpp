// LZF decompression. Source: the format of Marc Lehmann's liblzf, as PCD uses it.
#pragma once

#include <span>

#include "io/bytes.hpp"

namespace cairn::io {

// Most bytes that one compressed byte can stand for: three bytes copy up to 264.
inline constexpr std::uint64_t kLzfMaxRatio = 88;

// Fills `out` exactly. False where the data are damaged or do not give out.size() bytes;
// never reads or writes outside.
[[nodiscard]] bool lzf_decompress(Bytes in, std::span<std::byte> out);

}  // namespace cairn::io
