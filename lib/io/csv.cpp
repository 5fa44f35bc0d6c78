#include "io/csv.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <utility>

#include "base/number_text.hpp"

namespace cairn::io {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kBufferBytes = std::size_t{1} << 16;
constexpr std::size_t kMaxRecordBytes = std::size_t{1} << 20;
constexpr std::size_t kMaxCells = 10'000;
constexpr std::size_t kMaxMessageBytes = 60;  // of a bad value shown in a message

std::string shortened(std::string_view value) {
  if (value.empty()) return "an empty cell";
  std::string text = "'" + std::string(value.substr(0, kMaxMessageBytes)) + "'";
  if (value.size() > kMaxMessageBytes) text += "...";
  return text;
}

}  // namespace

struct CsvReader::Impl {
  std::string name;
  char separator = ',';
  int descriptor = -1;
  std::string storage;          // read buffer of a file
  std::string_view window;      // unread bytes
  bool at_end = false;          // nothing follows the window
  std::uint64_t file_line = 1;  // of the next byte
  std::uint64_t record_line = 1;

  std::string cells;              // text of the record's cells, one after the other
  std::vector<std::size_t> ends;  // end of each cell in `cells`
  std::vector<std::string> header, comments;

  ~Impl() {
    if (descriptor >= 0) ::close(descriptor);
  }

  void refill() {
    if (descriptor < 0) {
      at_end = true;
      return;
    }
    ssize_t n = 0;
    do n = ::read(descriptor, storage.data(), storage.size());
    while (n < 0 && errno == EINTR);
    if (n < 0)
      throw Error(ErrorCode::invalid_input, std::string("cannot read the file: ") + std::strerror(errno)).file(name);
    window = std::string_view(storage.data(), static_cast<std::size_t>(n));
    at_end = n == 0;
  }
  // Next byte, or -1 at the end.
  int peek() {
    if (window.empty() && !at_end) refill();
    return window.empty() ? -1 : static_cast<unsigned char>(window.front());
  }
  int take() {
    const int c = peek();
    if (c >= 0) window.remove_prefix(1);
    if (c == '\n') ++file_line;
    return c;
  }

  Error problem(std::string message, std::uint64_t at_line) const {
    std::string record = "line " + std::to_string(at_line);
    const std::size_t cell = ends.size();
    record += ", column " + (cell < header.size() ? header[cell] : std::to_string(cell + 1));
    return Error(ErrorCode::invalid_input, std::move(message)).file(name).record(record);
  }
  void append(int c) {
    if (c == 0) throw problem("NUL byte in a text table", file_line).hint("Is this a binary file?");
    if (cells.size() >= kMaxRecordBytes)
      throw problem("record too long", record_line).allowed("at most " + std::to_string(kMaxRecordBytes) + " bytes");
    cells += static_cast<char>(c);
  }
  // True where a line end was taken: LF or CRLF.
  bool take_line_end(int c) {
    if (c == '\n') return true;
    if (c == '\r' && peek() == '\n') {
      take();
      return true;
    }
    return false;
  }

  void read_quoted() {
    const std::uint64_t opened = file_line;
    while (true) {
      const int c = take();
      if (c < 0) throw problem("quote is never closed", opened).hint("Close the quote, or double a quote inside text");
      if (c != '"') {
        append(c);
      } else if (peek() == '"') {
        append(take());
      } else {
        return;
      }
    }
  }

  // Bytes up to the next one that means something go over in one piece.
  void take_plain_run() {
    std::size_t n = 0;
    while (n < window.size()) {
      const char c = window[n];
      if (c == separator || c == '\n' || c == '\r' || c == '"' || c == '\0') break;
      ++n;
    }
    if (cells.size() + n > kMaxRecordBytes)
      throw problem("record too long", record_line).allowed("at most " + std::to_string(kMaxRecordBytes) + " bytes");
    cells.append(window.substr(0, n));
    window.remove_prefix(n);
  }

  std::string comment_line() {
    std::string text;
    while (true) {
      const int c = take();
      if (c < 0 || c == '\n') break;
      if (text.size() < kMaxRecordBytes) text += static_cast<char>(c);
    }
    return std::string(base::trim(text));
  }

  // False at the end of the file.
  bool read_record() {
    cells.clear();
    ends.clear();
    while (true) {
      int c = peek();
      if (c < 0) return false;
      if (c == '#') {
        take();
        std::string comment = comment_line();
        if (header.empty()) comments.push_back(std::move(comment));
        continue;
      }
      record_line = file_line;
      if (c == '\n' || c == '\r') {
        take();
        if (take_line_end(c)) continue;
        append(c);
      }
      break;
    }
    while (true) {
      bool quoted = false;
      if (ends.size() >= kMaxCells)
        throw problem("too many cells in a row", record_line).allowed("at most " + std::to_string(kMaxCells));
      if (peek() == '"') {
        take();
        read_quoted();
        quoted = true;
      }
      while (true) {
        if (!quoted) take_plain_run();
        const int c = take();
        const bool line_end = c < 0 || take_line_end(c);
        if (line_end || c == separator) {
          ends.push_back(cells.size());
          if (line_end) return true;
          break;
        }
        if (quoted) throw problem("text after a closing quote", file_line).hint("Double a quote inside text");
        if (c == '"')
          throw problem("quote inside a cell that does not start with one", file_line)
              .hint("Put the whole cell in quotes and double the quote inside");
        append(c);
      }
    }
  }

  [[nodiscard]] std::string_view cell(std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends[i - 1];
    return std::string_view(cells).substr(begin, ends[i] - begin);
  }

  void start() {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    peek();
    if (window.starts_with(kByteOrderMark)) window.remove_prefix(kByteOrderMark.size());
    if (!read_record())
      throw Error(ErrorCode::invalid_input, "table without a header row")
          .file(name)
          .hint("The first row must name the columns");
    std::vector<std::string> names;
    for (std::size_t i = 0; i < ends.size(); ++i) names.emplace_back(base::trim(cell(i)));
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string where = "line " + std::to_string(record_line) + ", column " + std::to_string(i + 1);
      if (names[i].empty())
        throw Error(ErrorCode::invalid_input, "column without a name")
            .file(name)
            .record(where)
            .hint("Name every column");
      if (std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]) !=
          names.begin() + static_cast<std::ptrdiff_t>(i))
        throw Error(ErrorCode::invalid_input, "two columns of one name")
            .file(name)
            .record(where)
            .found(shortened(names[i]));
    }
    header = std::move(names);
  }
};

CsvReader::CsvReader(const std::filesystem::path& path, char separator) : impl_(std::make_unique<Impl>()) {
  impl_->name = path.string();
  impl_->separator = separator;
  impl_->descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (impl_->descriptor < 0)
    throw Error(ErrorCode::not_found, std::string("cannot read the file: ") + std::strerror(errno))
        .file(impl_->name)
        .hint("Check the path");
  impl_->storage.resize(kBufferBytes);
  impl_->start();
}

CsvReader::CsvReader(std::string_view text, std::string name, char separator) : impl_(std::make_unique<Impl>()) {
  impl_->name = std::move(name);
  impl_->separator = separator;
  impl_->window = text;
  impl_->start();
}

CsvReader::~CsvReader() = default;
CsvReader::CsvReader(CsvReader&&) noexcept = default;
CsvReader& CsvReader::operator=(CsvReader&&) noexcept = default;

const std::vector<std::string>& CsvReader::header() const {
  return impl_->header;
}
const std::vector<std::string>& CsvReader::comments() const {
  return impl_->comments;
}
std::uint64_t CsvReader::line() const {
  return impl_->record_line;
}

std::optional<std::size_t> CsvReader::find(std::string_view name) const {
  const auto it = std::find(impl_->header.begin(), impl_->header.end(), name);
  if (it == impl_->header.end()) return std::nullopt;
  return static_cast<std::size_t>(it - impl_->header.begin());
}

std::size_t CsvReader::column(std::string_view name) const {
  if (const auto index = find(name)) return *index;
  std::string known;
  for (const auto& there : impl_->header) known += (known.empty() ? "" : ", ") + there;
  throw Error(ErrorCode::invalid_input, "column '" + std::string(name) + "' is missing")
      .file(impl_->name)
      .record("header")
      .found(shortened(known))
      .hint("Add the column, or correct its name");
}

bool CsvReader::next() {
  if (!impl_->read_record()) return false;
  if (impl_->ends.size() != impl_->header.size())
    throw error("row with the wrong number of cells")
        .found(std::to_string(impl_->ends.size()))
        .allowed(std::to_string(impl_->header.size()) + ", as in the header");
  return true;
}

std::string_view CsvReader::text(std::size_t column) const {
  return impl_->cell(column);
}

std::string_view CsvReader::required(std::size_t column) const {
  const std::string_view value = text(column);
  if (base::trim(value).empty()) throw error(column, "value is missing").allowed("text");
  return value;
}

double CsvReader::real(std::size_t column) const {
  const auto value = base::parse_real(text(column));
  if (!value) throw error(column, "not a number").allowed("a number with a decimal point");
  if (!std::isfinite(*value)) throw error(column, "number is not finite").allowed("a finite number");
  return *value;
}

std::optional<double> CsvReader::optional_real(std::size_t column) const {
  if (base::trim(text(column)).empty()) return std::nullopt;
  return real(column);
}

std::int64_t CsvReader::integer(std::size_t column) const {
  const auto value = base::parse_integer(text(column));
  if (!value) throw error(column, "not a whole number").allowed("a whole number of at most 64 bits");
  return *value;
}

std::int64_t CsvReader::integer(std::size_t column, std::int64_t lo, std::int64_t hi) const {
  const std::int64_t value = integer(column);
  if (value < lo || value > hi)
    throw error(column, "number out of range").allowed(std::to_string(lo) + " to " + std::to_string(hi));
  return value;
}

Error CsvReader::error(std::size_t column, std::string message) const {
  return Error(ErrorCode::invalid_input, std::move(message))
      .file(impl_->name)
      .record("line " + std::to_string(line()) + ", column " + impl_->header[column])
      .found(shortened(text(column)));
}

Error CsvReader::error(std::string message) const {
  return Error(ErrorCode::invalid_input, std::move(message)).file(impl_->name).record("line " + std::to_string(line()));
}

std::string csv_quoted(std::string_view text) {
  constexpr std::string_view kRisky = "=+-@#";
  constexpr std::string_view kBlank = " \t";
  const bool quote = text.find_first_of(",\"\r\n") != std::string_view::npos ||
                     (!text.empty() && (kRisky.find(text.front()) != std::string_view::npos ||
                                        kBlank.find(text.front()) != std::string_view::npos ||
                                        kBlank.find(text.back()) != std::string_view::npos));
  if (!quote) return std::string(text);
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

CsvWriter::CsvWriter(const std::filesystem::path& path, std::span<const std::string_view> header)
    : path_(path), columns_(header.size()) {
  descriptor_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor_ < 0)
    throw Error(ErrorCode::resource_exhausted, std::string("cannot create the file: ") + std::strerror(errno))
        .file(path.string())
        .hint("Check that the folder exists and can be written");
  for (const auto name : header) cell(name);
  end_row();
}

CsvWriter::~CsvWriter() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void CsvWriter::separate() {
  if (cells_++ > 0) buffer_ += ',';
}

CsvWriter& CsvWriter::cell(std::string_view text) {
  separate();
  // A lone empty cell would read as a blank line.
  buffer_ += columns_ == 1 && text.empty() ? std::string("\"\"") : csv_quoted(text);
  return *this;
}

CsvWriter& CsvWriter::cell(double value) {
  separate();
  if (std::isfinite(value)) buffer_ += base::to_text(value);
  return *this;
}

CsvWriter& CsvWriter::cell(std::int64_t value) {
  separate();
  buffer_ += std::to_string(value);
  return *this;
}

CsvWriter& CsvWriter::cell(std::uint64_t value) {
  separate();
  buffer_ += std::to_string(value);
  return *this;
}

CsvWriter& CsvWriter::cell(std::optional<double> value) {
  if (value) return cell(*value);
  separate();
  return *this;
}

void CsvWriter::end_row() {
  if (cells_ != columns_)
    throw Error(ErrorCode::internal,
                "table row of " + std::to_string(cells_) + " cells for " + std::to_string(columns_) + " columns")
        .file(path_.string());
  cells_ = 0;
  buffer_ += '\n';
  if (buffer_.size() >= kBufferBytes) flush();
}

void CsvWriter::flush() {
  std::size_t written = 0;
  while (written < buffer_.size()) {
    const ssize_t n = ::write(descriptor_, buffer_.data() + written, buffer_.size() - written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      throw Error(ErrorCode::resource_exhausted, std::string("write failed: ") + std::strerror(n < 0 ? errno : ENOSPC))
          .file(path_.string())
          .hint("Free some disk space and run again");
    written += static_cast<std::size_t>(n);
  }
  buffer_.clear();
}

void CsvWriter::finish() {
  flush();
  if (::close(std::exchange(descriptor_, -1)) != 0)
    throw Error(ErrorCode::resource_exhausted, std::string("cannot finish the file: ") + std::strerror(errno))
        .file(path_.string())
        .hint("Free some disk space and run again");
}

}  // namespace cairn::io
