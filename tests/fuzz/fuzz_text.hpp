// Hands the fuzzer's bytes to a reader of memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "base/error.hpp"

namespace cairn::testing {

inline std::string_view as_text(const std::uint8_t* data, std::size_t size) {
  return {static_cast<const char*>(static_cast<const void*>(data)), size};
}

// Three files in one input: four bytes give the lengths of the first two, the third is the rest.
inline std::array<std::string_view, 3> three_files(const std::uint8_t* data, std::size_t size) {
  if (size < 4) return {};
  const std::string_view rest = as_text(data + 4, size - 4);
  const std::size_t first = std::size_t{data[0]} | std::size_t{data[1]} << 8;
  const std::size_t second = std::size_t{data[2]} | std::size_t{data[3]} << 8;
  const auto a = rest.substr(0, first), b = rest.substr(a.size()).substr(0, second);
  return {a, b, rest.substr(a.size() + b.size())};
}

// Calls read(); base::Error with code invalid_input (or crs_mismatch, for positions) is a fine answer.
template <typename Read>
int fuzz_text(const Read& read) {
  try {
    read();
  } catch (const base::Error& error) {
    if (error.code() != base::ErrorCode::invalid_input && error.code() != base::ErrorCode::crs_mismatch) std::abort();
  }
  return 0;
}

}  // namespace cairn::testing
