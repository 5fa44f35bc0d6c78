// Hands the fuzzer's bytes to a reader of files.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/error.hpp"

namespace cairn::testing {

// Calls read(path) with a file that holds the bytes; base::Error with code invalid_input is a fine
// answer, everything else is a finding.
template <typename Read>
int fuzz_file(const std::uint8_t* data, std::size_t size, const Read& read) {
  static const int file = ::memfd_create("fuzz", 0);
  static const std::filesystem::path path = "/proc/self/fd/" + std::to_string(file);
  if (::ftruncate(file, 0) != 0) std::abort();
  std::size_t done = 0;
  while (done < size) {
    const ssize_t put = ::pwrite(file, data + done, size - done, static_cast<off_t>(done));
    if (put <= 0) std::abort();
    done += static_cast<std::size_t>(put);
  }
  try {
    read(path);
  } catch (const base::Error& error) {
    if (error.code() != base::ErrorCode::invalid_input || error.record().empty()) std::abort();
  }
  return 0;
}

}  // namespace cairn::testing
