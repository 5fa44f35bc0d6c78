// Comma-separated tables: RFC 4180 with a header row, read and written row by row.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace cairn::io {

// Reads a table with a header row. Accepted beside RFC 4180: a UTF-8 byte-order mark, LF or CRLF,
// blank lines (skipped), lines whose first character is '#' (comments; those before the header are
// kept). Refused with file, line and column: an unclosed quote, text after a closing quote, a quote
// inside a bare cell, a NUL byte, a record longer than 1 MiB, a row with another number of cells than
// the header, a header name that is empty or appears twice.
// Memory: one record and a 64 KiB buffer. Cost linear in bytes.
class CsvReader {
 public:
  // Throws not_found, or invalid_input for an empty file or a bad header.
  explicit CsvReader(const std::filesystem::path& path, char separator = ',');
  // The same from memory; `name` stands for the file in messages. The text must outlive the reader.
  CsvReader(std::string_view text, std::string name, char separator);
  ~CsvReader();
  CsvReader(CsvReader&&) noexcept;
  CsvReader& operator=(CsvReader&&) noexcept;

  [[nodiscard]] const std::vector<std::string>& header() const;
  // Comment lines before the header, without '#' and surrounding blanks.
  [[nodiscard]] const std::vector<std::string>& comments() const;

  // Index of a column; throws invalid_input naming the missing column and those there are.
  [[nodiscard]] std::size_t column(std::string_view name) const;
  [[nodiscard]] std::optional<std::size_t> find(std::string_view name) const;

  // Steps to the next row; false at the end.
  [[nodiscard]] bool next();
  // Line of the current row in the file, from 1.
  [[nodiscard]] std::uint64_t line() const;

  // Cells of the current row, by column index. The view is valid until next().
  [[nodiscard]] std::string_view text(std::size_t column) const;
  // Text that is not empty.
  [[nodiscard]] std::string_view required(std::size_t column) const;
  // Finite number; throws invalid_input with line, column, value otherwise.
  [[nodiscard]] double real(std::size_t column) const;
  // Empty cell = nothing.
  [[nodiscard]] std::optional<double> optional_real(std::size_t column) const;
  [[nodiscard]] std::int64_t integer(std::size_t column) const;
  // Integer in lo..hi.
  [[nodiscard]] std::int64_t integer(std::size_t column, std::int64_t lo, std::int64_t hi) const;

  // An error about a cell of the current row: file, "line 7, column score", the value; add allowed().
  [[nodiscard]] base::Error error(std::size_t column, std::string message) const;
  // An error about the current row.
  [[nodiscard]] base::Error error(std::string message) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// Writes a table with LF line ends. Cells are quoted where RFC 4180 asks for it, where they start or
// end with a blank, and text cells that start with = + - @ or # (a spreadsheet would run the former,
// a reader here would skip the latter). Reals in shortest round-trip form; a non-finite one becomes an
// empty cell. Every write is checked: resource_exhausted with the path on failure.
class CsvWriter {
 public:
  CsvWriter(const std::filesystem::path& path, std::span<const std::string_view> header);
  CsvWriter(const std::filesystem::path& path, std::initializer_list<std::string_view> header)
      : CsvWriter(path, std::span<const std::string_view>(header.begin(), header.size())) {}
  ~CsvWriter();
  CsvWriter(const CsvWriter&) = delete;
  CsvWriter& operator=(const CsvWriter&) = delete;

  CsvWriter& cell(std::string_view text);
  CsvWriter& cell(const char* text) { return cell(std::string_view(text)); }
  CsvWriter& cell(double value);
  CsvWriter& cell(std::int64_t value);
  CsvWriter& cell(std::uint64_t value);
  CsvWriter& cell(int value) { return cell(static_cast<std::int64_t>(value)); }
  CsvWriter& cell(std::optional<double> value);
  // Ends the row; throws internal where its number of cells is not the header's.
  void end_row();
  // Writes what is buffered and closes. Without it the file is incomplete.
  void finish();

 private:
  void separate();
  void flush();

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::string buffer_;
  std::size_t columns_ = 0, cells_ = 0;
};

// One cell of text, quoted by the rules above.
[[nodiscard]] std::string csv_quoted(std::string_view text);

}  // namespace cairn::io
