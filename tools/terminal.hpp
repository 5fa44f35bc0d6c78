// Messages and progress on stderr; data on stdout.
#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

#include "base/run_context.hpp"

namespace cairn::tools {

// Thread-safe. A bar is drawn only when stderr is a terminal; NO_COLOR is honoured.
class Terminal final : public base::Listener {
 public:
  Terminal();
  void configure(bool quiet, bool verbose, std::string_view progress);
  void message(base::LogLevel level, std::string_view text) override;
  void progress(std::string_view what, std::uint64_t done, std::uint64_t total) override;
  // Clears a bar that is still on the line.
  void finish();

 private:
  void clear_line();

  std::mutex mutex_;
  bool quiet_ = false, verbose_ = false, json_ = false, bar_ = false, colour_ = false, line_open_ = false;
  std::chrono::steady_clock::time_point last_{};
};

// Writes to stdout; throws resource_exhausted where it cannot (a full disk behind a redirect).
void print_out(std::string_view text);

}  // namespace cairn::tools
