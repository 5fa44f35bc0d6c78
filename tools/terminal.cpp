#include "tools/terminal.hpp"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "base/error.hpp"
#include "base/memory.hpp"
#include "io/json.hpp"

namespace cairn::tools {

Terminal::Terminal() : bar_(::isatty(STDERR_FILENO) != 0), colour_(bar_ && std::getenv("NO_COLOR") == nullptr) {}

void Terminal::configure(bool quiet, bool verbose, std::string_view progress) {
  quiet_ = quiet;
  verbose_ = verbose;
  json_ = progress == "json";
  if (progress == "none" || json_ || quiet) bar_ = false;
}

void Terminal::clear_line() {
  if (line_open_) std::fputs("\r\033[K", stderr);
  line_open_ = false;
}

void Terminal::message(base::LogLevel level, std::string_view text) {
  const std::lock_guard lock(mutex_);
  if (quiet_ || (level == base::LogLevel::debug && !verbose_)) return;
  clear_line();
  const bool warning = level == base::LogLevel::warning;
  if (warning) std::fputs(colour_ ? "\033[33mwarning:\033[0m " : "warning: ", stderr);
  std::fprintf(stderr, "%.*s\n", static_cast<int>(text.size()), text.data());
}

void Terminal::progress(std::string_view what, std::uint64_t done, std::uint64_t total) {
  const std::lock_guard lock(mutex_);
  if (!bar_ && !json_) return;
  const auto now = std::chrono::steady_clock::now();
  constexpr auto kInterval = std::chrono::milliseconds(100);
  if (done != total && now - last_ < kInterval) return;
  last_ = now;
  if (json_) {
    const std::string line = io::Json::object({{"stage", what},
                                               {"done", static_cast<std::int64_t>(done)},
                                               {"total", static_cast<std::int64_t>(total)},
                                               {"rss_bytes", static_cast<std::int64_t>(base::resident_bytes())}})
                                 .dump(0);
    std::fprintf(stderr, "%s\n", line.c_str());
    return;
  }
  clear_line();
  std::fprintf(stderr, "%.*s %llu/%llu", static_cast<int>(what.size()), what.data(),
               static_cast<unsigned long long>(done), static_cast<unsigned long long>(total));
  std::fflush(stderr);
  line_open_ = true;
}

void Terminal::finish() {
  const std::lock_guard lock(mutex_);
  clear_line();
}

void print_out(std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    throw base::Error(base::ErrorCode::resource_exhausted, "cannot write to standard output");
}

}  // namespace cairn::tools
