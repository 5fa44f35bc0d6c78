// Binary PGM images (P5, 8 bits).
#pragma once

#include <string>
#include <string_view>

#include "io/map_image.hpp"

namespace cairn::io {

// name: what messages call the file. Bytes after the last pixel are ignored. Throws invalid_input with the byte.
[[nodiscard]] MapImage read_pgm(const std::string& name, std::string_view bytes);

}  // namespace cairn::io
