#include <zlib.h>

#include "base/error.hpp"
#include "report/deflate.hpp"

namespace cairn::report {

std::string zlib_compressed(std::string_view bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(size, '\0');
  const int status = compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                               reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()), 9);
  if (status != Z_OK)
    throw base::Error(base::ErrorCode::resource_exhausted, "an image of the report could not be compressed")
        .found(std::to_string(bytes.size()) + " bytes")
        .hint("Free memory, or lower --max-raster-px.");
  out.resize(size);
  return out;
}

std::uint32_t crc32_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32(0L, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

}  // namespace cairn::report
