#include <cerrno>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>

#include "base/error.hpp"
#include "io/image_metadata.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

// Bytes at an offset; fewer than asked at the end of the file.
using ReadAt = std::function<std::string(std::uint64_t offset, std::size_t count)>;

class Scanner {
 public:
  Scanner(ReadAt read, std::string_view name) : read_(std::move(read)), name_(name) {}

  ImageSize size() {
    constexpr std::string_view kPng = "\x89PNG\r\n\x1A\n";
    const std::string start = read_(0, kPng.size());
    if (start.starts_with("\xFF\xD8")) return jpeg();
    if (start == kPng) return png();
    throw Error(ErrorCode::invalid_input, "not an image that cairn reads")
        .file(name_)
        .record("byte 0")
        .allowed("JPEG or PNG")
        .hint("Check that the file is a photograph and came over whole");
  }

 private:
  unsigned byte_at(std::uint64_t offset, std::size_t index, const std::string& bytes) {
    if (index >= bytes.size()) fail(offset + index, "image file ends inside its header");
    return static_cast<unsigned char>(bytes[index]);
  }
  [[noreturn]] void fail(std::uint64_t offset, std::string message) {
    throw Error(ErrorCode::invalid_input, std::move(message))
        .file(name_)
        .record("byte " + std::to_string(offset))
        .hint("The image is cut off or damaged; copy it again");
  }
  ImageSize checked(std::uint64_t offset, std::int64_t width, std::int64_t height) {
    constexpr std::int64_t kMaxPixels = 4'000'000'000;
    if (width <= 0 || height <= 0 || width > kMaxPixels / height)
      fail(offset, "image of impossible size " + std::to_string(width) + " x " + std::to_string(height));
    return {width, height};
  }

  // Walks the segments up to the frame header (SOF0..SOF15 but DHT, JPG and DAC): ITU T.81, B.1.1.3.
  ImageSize jpeg() {
    std::uint64_t at = 2;
    // A JPEG has few segments before its frame; the limit stops a file of nothing but markers.
    for (int segments = 0; segments < 10'000; ++segments) {
      const std::string head = read_(at, 9);
      if (byte_at(at, 0, head) != 0xFF) fail(at, "JPEG marker expected");
      const unsigned marker = byte_at(at, 1, head);
      if (marker == 0xFF) {  // fill byte
        ++at;
        continue;
      }
      if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {  // markers without a segment
        at += 2;
        continue;
      }
      if (marker == 0xD9 || marker == 0xDA) fail(at, "JPEG without a frame header");
      const unsigned length = byte_at(at, 2, head) << 8 | byte_at(at, 3, head);
      if (length < 2) fail(at, "JPEG segment of impossible length");
      const bool frame = marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
      if (frame) {
        const unsigned height = byte_at(at, 5, head) << 8 | byte_at(at, 6, head);
        const unsigned width = byte_at(at, 7, head) << 8 | byte_at(at, 8, head);
        return checked(at, width, height);
      }
      at += 2 + length;
    }
    fail(at, "JPEG without a frame header");
  }

  ImageSize png() {
    constexpr std::uint64_t kHeader = 8;
    const std::string head = read_(kHeader, 16);
    const auto u32 = [&](std::size_t i) {
      std::int64_t value = 0;
      for (std::size_t k = 0; k < 4; ++k) value = value << 8 | byte_at(kHeader, i + k, head);
      return value;
    };
    const std::int64_t width = u32(8), height = u32(12);
    if (std::string_view(head).substr(4, 4) != "IHDR") fail(kHeader, "PNG without its header chunk");
    return checked(kHeader, width, height);
  }

  ReadAt read_;
  std::string name_;
};

}  // namespace

ImageSize image_size_of(std::string_view bytes, std::string_view name) {
  return Scanner(
             [bytes](std::uint64_t offset, std::size_t count) {
               return offset >= bytes.size() ? std::string()
                                             : std::string(bytes.substr(static_cast<std::size_t>(offset), count));
             },
             name)
      .size();
}

ImageSize read_image_size(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path))
    throw Error(ErrorCode::not_found, std::string("cannot read the image: ") + std::strerror(errno))
        .file(path.string())
        .hint("Check the path");
  return Scanner(
             [&file](std::uint64_t offset, std::size_t count) {
               std::string bytes(count, '\0');
               file.clear();
               file.seekg(static_cast<std::streamoff>(offset));
               file.read(bytes.data(), static_cast<std::streamsize>(count));
               bytes.resize(file.gcount() > 0 ? static_cast<std::size_t>(file.gcount()) : 0);
               return bytes;
             },
             path.string())
      .size();
}

}  // namespace cairn::io
