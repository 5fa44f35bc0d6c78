// Compression of what is embedded in the page.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace cairn::report {

// zlib stream (RFC 1950) of the bytes, at the best level. Throws resource_exhausted where memory ends.
[[nodiscard]] std::string zlib_compressed(std::string_view bytes);
// CRC-32 as PNG uses it.
[[nodiscard]] std::uint32_t crc32_of(std::string_view bytes);

}  // namespace cairn::report
