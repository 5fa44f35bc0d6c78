// Bounded reading of untrusted files, and writing where every failure is seen.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/error.hpp"

namespace cairn::io {

static_assert(std::endian::native == std::endian::little, "readers and writers assume a little-endian machine");

using Bytes = std::span<const std::byte>;

// One scalar at an address that holds at least sizeof(T) bytes; no alignment needed.
template <typename T>
[[nodiscard]] T load_le(const std::byte* from) {
  static_assert(std::is_arithmetic_v<T>);
  T value;
  std::memcpy(&value, from, sizeof(T));
  return value;
}
template <typename T>
[[nodiscard]] T load_be(const std::byte* from) {
  std::byte turned[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) turned[i] = from[sizeof(T) - 1 - i];
  return load_le<T>(turned);
}

// Error{invalid_input} about one place of a file.
[[nodiscard]] base::Error bad_bytes(std::string_view file, std::uint64_t offset, std::string message);
[[nodiscard]] base::Error bad_line(std::string_view file, std::uint64_t line, std::string message);

// Text up to the first NUL, without trailing blanks; bytes that are not printable ASCII become '?'.
[[nodiscard]] std::string printable_text(Bytes bytes);

// A regular file opened for reading at given offsets; safe from several threads.
class InputFile {
 public:
  // Throws not_found where the file cannot be opened, invalid_input where it is no regular file.
  explicit InputFile(const std::filesystem::path& path);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  [[nodiscard]] std::uint64_t size() const noexcept { return size_; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }
  // Fills `out` from `offset`; throws invalid_input where the file ends before.
  void read_at(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  std::string name_;
  std::uint64_t size_ = 0;
  int fd_ = -1;
};

// A whole file in memory.
class FileBytes {
 public:
  explicit FileBytes(const std::filesystem::path& path);
  [[nodiscard]] Bytes bytes() const noexcept { return {data_.get(), size_}; }
  [[nodiscard]] std::string_view text() const noexcept { return {reinterpret_cast<const char*>(data_.get()), size_}; }
  [[nodiscard]] const std::string& name() const noexcept { return name_; }

 private:
  std::string name_;
  std::unique_ptr<std::byte[]> data_;
  std::size_t size_ = 0;
};

enum class Endian { little, big };

// Reads scalars one after another; every step past the end throws with the offset.
class ByteReader {
 public:
  // file: for messages; base: offset of data[0] in that file.
  ByteReader(Bytes data, std::string_view file, std::uint64_t base = 0, Endian endian = Endian::little)
      : data_(data), file_(file), base_(base), endian_(endian) {}

  template <typename T>
  [[nodiscard]] T read(std::string_view what) {
    need(sizeof(T), what);
    const std::byte* from = data_.data() + position_;
    position_ += sizeof(T);
    return endian_ == Endian::little ? load_le<T>(from) : load_be<T>(from);
  }
  [[nodiscard]] Bytes bytes(std::uint64_t count, std::string_view what) {
    need(count, what);
    const Bytes part = data_.subspan(position_, static_cast<std::size_t>(count));
    position_ += part.size();
    return part;
  }
  void skip(std::uint64_t count, std::string_view what) { (void)bytes(count, what); }

  [[nodiscard]] std::uint64_t offset() const noexcept { return base_ + position_; }
  [[nodiscard]] std::size_t remaining() const noexcept { return data_.size() - position_; }
  [[nodiscard]] base::Error error(std::string message) const { return bad_bytes(file_, offset(), std::move(message)); }

 private:
  void need(std::uint64_t count, std::string_view what) const;

  Bytes data_;
  std::string_view file_;
  std::uint64_t base_;
  std::size_t position_ = 0;
  Endian endian_;
};

// Text cut into lines (LF, CR LF or CR) and blank-separated words, with the line number kept.
class TextReader {
 public:
  TextReader(std::string_view text, std::string_view file, std::uint64_t first_line = 1)
      : text_(text), file_(file), line_(first_line - 1) {}

  // Next line without its end, or nothing at the end of the text.
  [[nodiscard]] std::optional<std::string_view> next_line();
  // Next word, across lines, or nothing at the end of the text.
  [[nodiscard]] std::optional<std::string_view> next_word();

  // 1-based number of the line last given, and the offset just behind it.
  [[nodiscard]] std::uint64_t line() const noexcept { return line_; }
  [[nodiscard]] std::size_t offset() const noexcept { return position_; }
  [[nodiscard]] std::size_t remaining() const noexcept { return text_.size() - position_; }
  [[nodiscard]] base::Error error(std::string message) const { return bad_line(file_, line_, std::move(message)); }

 private:
  std::string_view text_, file_;
  std::size_t position_ = 0;
  std::uint64_t line_;
  bool inside_line_ = false;  // next_word stopped within a line
};

// First blank-separated word of a line, removed from it; empty at the end.
[[nodiscard]] std::string_view take_word(std::string_view& line);

// A number as text files spell it: optional '+', decimal point, exponent; "nan" and "inf" are
// accepted (the caller counts them). Nothing where the whole word is not one number.
[[nodiscard]] std::optional<double> parse_number(std::string_view word);

// Sequential writer with a buffer; every failed write throws resource_exhausted with the byte count.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;

  void write(Bytes bytes);
  void write(std::string_view text) { write(std::as_bytes(std::span(text.data(), text.size()))); }
  // Scalars, little-endian.
  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T>);
    write(std::as_bytes(std::span(&value, 1)));
  }
  // Text padded with NUL to exactly `width` bytes, cut where longer.
  void put_text(std::string_view text, std::size_t width);
  void put_zeros(std::size_t count);
  [[nodiscard]] std::uint64_t written() const noexcept { return written_; }
  // Must be called: reports what a late write or close reports.
  void close();

 private:
  void flush();

  std::string name_;
  int fd_ = -1;
  std::uint64_t written_ = 0;
  std::vector<std::byte> buffer_;
};

// Asks the system for large pages under memory that is about to be filled: halves the cost of
// first touching gigabytes. No effect on content.
void advise_large_pages(void* begin, std::size_t bytes) noexcept;

}  // namespace cairn::io
