#include "io/bytes.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <utility>

namespace cairn::io {
namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20;
constexpr std::size_t kLargePage = std::size_t{1} << 21;

bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

base::Error write_error(const std::string& file, std::uint64_t written, int code) {
  return base::Error(base::ErrorCode::resource_exhausted, std::string("cannot write: ") + std::strerror(code))
      .file(file)
      .record("byte " + std::to_string(written))
      .hint(code == ENOSPC ? "Free some disk space and run again" : "Check that the folder exists and can be written");
}

}  // namespace

base::Error bad_bytes(std::string_view file, std::uint64_t offset, std::string message) {
  return base::Error(base::ErrorCode::invalid_input, std::move(message))
      .file(file)
      .record("byte " + std::to_string(offset));
}

base::Error bad_line(std::string_view file, std::uint64_t line, std::string message) {
  return base::Error(base::ErrorCode::invalid_input, std::move(message))
      .file(file)
      .record("line " + std::to_string(line));
}

std::string printable_text(Bytes bytes) {
  std::string text;
  for (const std::byte b : bytes) {
    const char c = static_cast<char>(b);
    if (c == '\0') break;
    text += c >= ' ' && c <= '~' ? c : '?';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

InputFile::InputFile(const std::filesystem::path& path) : name_(path.string()) {
  // Without O_NONBLOCK, opening a named pipe would wait for a writer.
  fd_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd_ < 0)
    throw base::Error(base::ErrorCode::not_found, std::string("cannot open: ") + std::strerror(errno))
        .file(name_)
        .hint("Check the path");
  struct stat facts {};
  if (::fstat(fd_, &facts) != 0 || !S_ISREG(facts.st_mode)) {
    ::close(fd_);
    throw base::Error(base::ErrorCode::invalid_input, "not a regular file")
        .file(name_)
        .hint("Name a file on disk; pipes, devices and folders cannot be read");
  }
  size_ = static_cast<std::uint64_t>(facts.st_size);
}

InputFile::~InputFile() {
  ::close(fd_);
}

void InputFile::read_at(std::uint64_t offset, std::span<std::byte> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t got = ::pread(fd_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      throw base::Error(base::ErrorCode::invalid_input, std::string("cannot read: ") + std::strerror(errno))
          .file(name_)
          .record("byte " + std::to_string(offset + done));
    if (got == 0)
      throw bad_bytes(name_, offset + done, "the file ends too early")
          .found(std::to_string(offset + done) + " bytes")
          .allowed("at least " + std::to_string(offset + out.size()))
          .hint("The file is truncated: copy it again from its source");
    done += static_cast<std::size_t>(got);
  }
}

FileBytes::FileBytes(const std::filesystem::path& path) {
  const InputFile file(path);
  name_ = file.name();
  size_ = static_cast<std::size_t>(file.size());
  data_ = std::make_unique_for_overwrite<std::byte[]>(size_);
  advise_large_pages(data_.get(), size_);
  file.read_at(0, {data_.get(), size_});
}

void ByteReader::need(std::uint64_t count, std::string_view what) const {
  if (count > remaining())
    throw bad_bytes(file_, offset(), "the data end inside " + std::string(what))
        .found(std::to_string(remaining()) + " bytes left")
        .allowed("at least " + std::to_string(count))
        .hint("The file is truncated or its header is wrong");
}

std::optional<std::string_view> TextReader::next_line() {
  if (position_ >= text_.size()) return std::nullopt;
  if (!inside_line_) ++line_;
  inside_line_ = false;
  const std::size_t begin = position_;
  const std::size_t end = std::min(text_.find_first_of("\r\n", begin), text_.size());
  position_ = end;
  if (position_ < text_.size()) {
    const bool two = text_[position_] == '\r' && position_ + 1 < text_.size() && text_[position_ + 1] == '\n';
    position_ += two ? std::size_t{2} : std::size_t{1};
  }
  return text_.substr(begin, end - begin);
}

std::optional<std::string_view> TextReader::next_word() {
  for (;;) {
    while (position_ < text_.size() && is_blank(text_[position_])) ++position_;
    if (position_ >= text_.size()) return std::nullopt;
    if (!inside_line_) {
      inside_line_ = true;
      ++line_;
    }
    const char c = text_[position_];
    if (c != '\n' && c != '\r') break;
    const bool two = c == '\r' && position_ + 1 < text_.size() && text_[position_ + 1] == '\n';
    position_ += two ? std::size_t{2} : std::size_t{1};
    inside_line_ = false;
  }
  const std::size_t begin = position_;
  while (position_ < text_.size() && !is_blank(text_[position_]) && text_[position_] != '\n' &&
         text_[position_] != '\r')
    ++position_;
  return text_.substr(begin, position_ - begin);
}

std::string_view take_word(std::string_view& line) {
  std::size_t begin = 0;
  while (begin < line.size() && is_blank(line[begin])) ++begin;
  std::size_t end = begin;
  while (end < line.size() && !is_blank(line[end])) ++end;
  const std::string_view word = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return word;
}

std::optional<double> parse_number(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double value = 0.0;
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || word.empty()) return std::nullopt;
  // Too small for a double reads as zero; too large is no number.
  if (code == std::errc::result_out_of_range) {
    const std::size_t exponent = word.find_first_of("eE");
    if (exponent != std::string_view::npos && word.substr(exponent + 1).starts_with('-')) return 0.0;
    return std::nullopt;
  }
  if (code != std::errc{}) return std::nullopt;
  return value;
}

OutputFile::OutputFile(const std::filesystem::path& path) : name_(path.string()) {
  fd_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd_ < 0) throw write_error(name_, 0, errno);
  buffer_.reserve(kBufferBytes);
}

OutputFile::~OutputFile() {
  if (fd_ >= 0) ::close(fd_);
}

void OutputFile::write(Bytes bytes) {
  if (buffer_.size() + bytes.size() > kBufferBytes) flush();
  if (bytes.size() > kBufferBytes) {
    while (!bytes.empty()) {
      const std::size_t part = std::min(bytes.size(), kBufferBytes);
      buffer_.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(part));
      bytes = bytes.subspan(part);
      flush();
    }
    return;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void OutputFile::put_text(std::string_view text, std::size_t width) {
  text = text.substr(0, width);
  write(text);
  put_zeros(width - text.size());
}

void OutputFile::put_zeros(std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) put(std::uint8_t{0});
}

void OutputFile::flush() {
  std::size_t done = 0;
  while (done < buffer_.size()) {
    const ssize_t put = ::write(fd_, buffer_.data() + done, buffer_.size() - done);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) throw write_error(name_, written_ + done, put < 0 ? errno : ENOSPC);
    done += static_cast<std::size_t>(put);
  }
  written_ += buffer_.size();
  buffer_.clear();
}

void OutputFile::close() {
  flush();
  if (::close(std::exchange(fd_, -1)) != 0) throw write_error(name_, written_, errno);
}

void advise_large_pages(void* begin, std::size_t bytes) noexcept {
  const auto from = (reinterpret_cast<std::uintptr_t>(begin) + kLargePage - 1) / kLargePage * kLargePage;
  const auto to = (reinterpret_cast<std::uintptr_t>(begin) + bytes) / kLargePage * kLargePage;
  if (to > from) ::madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE);
}

}  // namespace cairn::io
