#include "io/lzf.hpp"

#include <algorithm>

namespace cairn::io {

bool lzf_decompress(Bytes in, std::span<std::byte> out) {
  std::size_t from = 0, to = 0;
  while (from < in.size()) {
    const auto control = std::to_integer<std::size_t>(in[from++]);
    if (control < 32) {  // literals
      const std::size_t length = control + 1;
      if (length > in.size() - from || length > out.size() - to) return false;
      std::copy_n(in.begin() + static_cast<std::ptrdiff_t>(from), length,
                  out.begin() + static_cast<std::ptrdiff_t>(to));
      from += length;
      to += length;
      continue;
    }
    std::size_t length = control >> 5U;
    if (length == 7) {
      if (from >= in.size()) return false;
      length += std::to_integer<std::size_t>(in[from++]);
    }
    length += 2;
    if (from >= in.size()) return false;
    const std::size_t back = ((control & 31U) << 8U) + std::to_integer<std::size_t>(in[from++]) + 1;
    if (back > to || length > out.size() - to) return false;
    // The two ranges may overlap: byte by byte, in order.
    for (std::size_t i = 0; i < length; ++i, ++to) out[to] = out[to - back];
  }
  return to == out.size();
}

}  // namespace cairn::io
