// Small JPEG files with the metadata a test needs: no picture, only headers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cairn::testing {

inline std::string big_endian16(std::size_t value) {
  return {static_cast<char>(value >> 8 & 0xFF), static_cast<char>(value & 0xFF)};
}

inline std::string jpeg_segment(unsigned char marker, std::string_view body) {
  return std::string("\xFF") + static_cast<char>(marker) + big_endian16(body.size() + 2) + std::string(body);
}

// Frame header of a grey baseline image.
inline std::string jpeg_frame(std::size_t width, std::size_t height) {
  return jpeg_segment(
      0xC0, std::string("\x08", 1) + big_endian16(height) + big_endian16(width) + std::string("\x01\x01\x11\x00", 4));
}

inline std::string xmp_segment(std::string_view rdf) {
  return jpeg_segment(0xE1, std::string("http://ns.adobe.com/xap/1.0/\0", 29) +
                                "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
                                "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">" +
                                std::string(rdf) + "</rdf:RDF></x:xmpmeta>");
}

// Little-endian TIFF structure of an Exif segment: IFD0 with a GPS and an Exif sub-directory.
class Exif {
 public:
  enum Folder { main, photo, gps };

  Exif& ascii(Folder folder, int tag, std::string text) {
    text += '\0';
    return add(folder, tag, 2, text.size(), text);
  }
  Exif& byte(Folder folder, int tag, int value) {
    return add(folder, tag, 1, 1, std::string(1, static_cast<char>(value)));
  }
  Exif& number(Folder folder, int tag, int value) {
    return add(folder, tag, 3, 1, little(static_cast<std::uint32_t>(value), 2));
  }
  Exif& rationals(Folder folder, int tag, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& values) {
    std::string bytes;
    for (const auto& [n, d] : values) bytes += little(n, 4) + little(d, 4);
    return add(folder, tag, 5, values.size(), bytes);
  }

  [[nodiscard]] std::string segment() const {
    std::vector<Entry> first = folders_[main];
    std::string body = "II*" + std::string(1, '\0') + little(8, 4);
    const std::size_t main_size = 2 + 12 * (first.size() + 2) + 4;
    const std::string photo_bytes = directory(folders_[photo], 8 + main_size);
    const std::string gps_bytes = directory(folders_[gps], 8 + main_size + photo_bytes.size());
    first.push_back({0x8769, 4, 1, little(static_cast<std::uint32_t>(8 + main_size), 4)});
    first.push_back({0x8825, 4, 1, little(static_cast<std::uint32_t>(8 + main_size + photo_bytes.size()), 4)});
    // Values of IFD0 that do not fit go behind everything else.
    std::string head = little(static_cast<std::uint32_t>(first.size()), 2), tail;
    const std::size_t tail_at = 8 + main_size + photo_bytes.size() + gps_bytes.size();
    for (const auto& e : first) head += entry(e, tail, tail_at);
    head += little(0, 4);
    return jpeg_segment(0xE1, std::string("Exif\0\0", 6) + body + head + photo_bytes + gps_bytes + tail);
  }

 private:
  struct Entry {
    int tag, type;
    std::size_t count;
    std::string bytes;
  };
  Exif& add(Folder folder, int tag, int type, std::size_t count, std::string bytes) {
    folders_[folder].push_back({tag, type, count, std::move(bytes)});
    return *this;
  }
  static std::string little(std::uint32_t value, int bytes) {
    std::string out;
    for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
    return out;
  }
  static std::string entry(const Entry& e, std::string& tail, std::size_t tail_at) {
    std::string out = little(static_cast<std::uint32_t>(e.tag), 2) + little(static_cast<std::uint32_t>(e.type), 2) +
                      little(static_cast<std::uint32_t>(e.count), 4);
    std::string value = e.bytes;
    if (value.size() <= 4) {
      value.resize(4, '\0');
      return out + value;
    }
    out += little(static_cast<std::uint32_t>(tail_at + tail.size()), 4);
    tail += value;
    return out;
  }
  static std::string directory(const std::vector<Entry>& entries, std::size_t at) {
    std::string head = little(static_cast<std::uint32_t>(entries.size()), 2), tail;
    const std::size_t tail_at = at + 2 + 12 * entries.size() + 4;
    for (const auto& e : entries) head += entry(e, tail, tail_at);
    return head + little(0, 4) + tail;
  }

  std::vector<Entry> folders_[3];
};

// Start of image, the given segments, a frame header, end of image.
inline std::string jpeg(const std::vector<std::string>& segments, std::size_t width = 1600, std::size_t height = 900) {
  std::string out = "\xFF\xD8";
  for (const auto& segment : segments) out += segment;
  return out + jpeg_frame(width, height) + "\xFF\xD9";
}

}  // namespace cairn::testing
