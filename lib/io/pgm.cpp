#include "io/pgm.hpp"

#include "base/error.hpp"

namespace cairn::io {
namespace {

constexpr std::size_t kMaxCells = std::size_t{1} << 31U;

class PgmReader {
 public:
  PgmReader(const std::string& name, std::string_view bytes) : name_(name), bytes_(bytes) {}

  MapImage read() {
    if (bytes_.rfind("P5", 0) != 0) refuse(0, "not a binary PGM (P5), PNG or BMP image");
    at_ = 2;
    MapImage image;
    image.columns = number("width");
    image.rows = number("height");
    image.maximum = static_cast<unsigned>(number("maximum"));
    if (image.maximum > 255) refuse(at_, "a PGM of more than 8 bits");
    if (at_ >= bytes_.size() || !is_space(bytes_[at_])) refuse(at_, "a PGM header that does not end");
    ++at_;
    if (image.columns > kMaxCells / image.rows || image.columns * image.rows > bytes_.size() - at_)
      refuse(at_, "a PGM with fewer pixels than its header says: " + std::to_string(image.columns) + " x " +
                      std::to_string(image.rows) + " in " + std::to_string(bytes_.size() - at_) + " bytes");
    image.colour.reserve(image.columns * image.rows);
    for (const char c : bytes_.substr(at_, image.columns * image.rows))
      image.colour.push_back(static_cast<std::uint16_t>(3 * static_cast<unsigned char>(c)));
    return image;
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\v' || c == '\f'; }

  std::size_t number(const char* what) {
    for (;;) {
      while (at_ < bytes_.size() && is_space(bytes_[at_])) ++at_;
      if (at_ >= bytes_.size() || bytes_[at_] != '#') break;
      while (at_ < bytes_.size() && bytes_[at_] != '\n') ++at_;
    }
    std::size_t value = 0;
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9' && at_ - begin < 10)
      value = value * 10 + static_cast<std::size_t>(bytes_[at_++] - '0');
    if (at_ == begin || value == 0) refuse(begin, std::string("a PGM header without a usable ") + what);
    return value;
  }

  [[noreturn]] void refuse(std::size_t byte, std::string message) const {
    throw base::Error(base::ErrorCode::invalid_input, std::move(message))
        .file(name_)
        .record("byte " + std::to_string(byte))
        .allowed("P5, width, height, maximum 1 to 255, then one byte a pixel");
  }

  const std::string& name_;
  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace

MapImage read_pgm(const std::string& name, std::string_view bytes) {
  return PgmReader(name, bytes).read();
}

}  // namespace cairn::io
