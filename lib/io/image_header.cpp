#include <algorithm>
#include <array>
#include <vector>

#include "base/error.hpp"
#include "io/bytes.hpp"
#include "io/image.hpp"

namespace cairn::io {
namespace {

using base::Error;

constexpr std::uint64_t kTail = 64 * 1024;  // searched for the end marker: writers pad and append

template <std::size_t N>
std::array<std::byte, N> bytes_at(const InputFile& file, std::uint64_t offset) {
  std::array<std::byte, N> out{};
  file.read_at(offset, out);
  return out;
}

unsigned octet(std::byte b) {
  return std::to_integer<unsigned>(b);
}

// Whether `wanted` occurs in the last kTail bytes, not before `from` (an embedded thumbnail has an end
// marker of its own).
bool ends_with_marker(const InputFile& file, std::uint64_t from, Bytes wanted) {
  if (from >= file.size()) return false;
  const std::uint64_t length = std::min(file.size() - from, kTail);
  std::vector<std::byte> tail(static_cast<std::size_t>(length));
  file.read_at(file.size() - length, tail);
  return std::search(tail.rbegin(), tail.rend(), wanted.rbegin(), wanted.rend()) != tail.rend();
}

Error truncated(const InputFile& file, std::string_view end) {
  return bad_bytes(file.name(), file.size(), "the image is truncated: it has no " + std::string(end))
      .found(std::to_string(file.size()) + " bytes")
      .hint("Copy the image again from its source");
}

// Start-of-frame markers: C0 to CF without DHT (C4), JPG (C8) and DAC (CC).
bool is_frame_marker(unsigned marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

ImageHeader read_jpeg(const InputFile& file) {
  std::uint64_t at = 2;
  while (true) {
    const auto start = bytes_at<2>(file, at);
    if (octet(start[0]) != 0xFF)
      throw bad_bytes(file.name(), at, "not a JPEG marker").found(std::to_string(octet(start[0]))).allowed("255");
    const unsigned marker = octet(start[1]);
    if (marker == 0xFF) {  // fill byte
      ++at;
      continue;
    }
    if (marker == 0x01 || (marker >= 0xD0 && marker <= 0xD7)) {  // no length
      at += 2;
      continue;
    }
    if (marker == 0xD9 || marker == 0xDA)
      throw bad_bytes(file.name(), at, "the JPEG has no frame header before its pixels");
    const auto length_bytes = bytes_at<2>(file, at + 2);
    const std::uint64_t length = load_be<std::uint16_t>(length_bytes.data());
    if (length < 2) throw bad_bytes(file.name(), at + 2, "JPEG segment is too short").found(std::to_string(length));
    if (is_frame_marker(marker)) {
      const auto frame = bytes_at<6>(file, at + 4);
      ImageHeader header;
      header.format = "JPEG";
      header.height_px = load_be<std::uint16_t>(frame.data() + 1);
      header.width_px = load_be<std::uint16_t>(frame.data() + 3);
      header.channels = static_cast<int>(octet(frame[5]));
      constexpr std::array<std::byte, 2> kEnd{std::byte{0xFF}, std::byte{0xD9}};
      if (!ends_with_marker(file, at + 2 + length, kEnd)) throw truncated(file, "end-of-image marker");
      return header;
    }
    at += 2 + length;
  }
}

ImageHeader read_png(const InputFile& file) {
  const auto ihdr = bytes_at<18>(file, 8);
  if (printable_text({ihdr.data() + 4, 4}) != "IHDR") throw bad_bytes(file.name(), 12, "the PNG has no IHDR chunk");
  ImageHeader header;
  header.format = "PNG";
  header.width_px = load_be<std::uint32_t>(ihdr.data() + 8);
  header.height_px = load_be<std::uint32_t>(ihdr.data() + 12);
  const unsigned colour = octet(ihdr[17]);
  header.channels = colour == 2 ? 3 : colour == 4 ? 2 : colour == 6 ? 4 : 1;
  constexpr std::uint64_t kHeaderEnd = 33;  // signature and IHDR chunk
  constexpr std::array<std::byte, 4> kEnd{std::byte{'I'}, std::byte{'E'}, std::byte{'N'}, std::byte{'D'}};
  if (!ends_with_marker(file, kHeaderEnd, kEnd)) throw truncated(file, "IEND chunk");
  return header;
}

}  // namespace

ImageHeader read_image_header(const std::filesystem::path& path) {
  const InputFile file(path);
  if (file.size() < 4)
    throw bad_bytes(file.name(), 0, "not an image")
        .found(std::to_string(file.size()) + " bytes")
        .allowed("a JPEG or PNG file");
  const auto magic = bytes_at<4>(file, 0);
  ImageHeader header;
  if (octet(magic[0]) == 0xFF && octet(magic[1]) == 0xD8) {
    header = read_jpeg(file);
  } else if (octet(magic[0]) == 0x89 && printable_text({magic.data() + 1, 3}) == "PNG") {
    header = read_png(file);
  } else {
    throw bad_bytes(file.name(), 0, "not an image that cairn reads")
        .found("'" + printable_text(magic) + "'")
        .allowed("a JPEG or PNG file");
  }
  header.file_bytes = file.size();
  if (header.width_px <= 0 || header.height_px <= 0)
    throw bad_bytes(file.name(), 0, "the image has no pixels")
        .found(std::to_string(header.width_px) + " x " + std::to_string(header.height_px));
  return header;
}

}  // namespace cairn::io
