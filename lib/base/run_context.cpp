#include "base/run_context.hpp"

#include <string>

#include "base/error.hpp"
#include "base/memory.hpp"

namespace cairn::base {

void RunContext::debug(std::string_view text) const {
  if (listener_ != nullptr) listener_->message(LogLevel::debug, text);
}

void RunContext::info(std::string_view text) const {
  if (listener_ != nullptr) listener_->message(LogLevel::info, text);
}

void RunContext::warn(std::string_view text) {
  warnings_.emplace_back(text);
  if (listener_ != nullptr) listener_->message(LogLevel::warning, text);
}

void RunContext::progress(std::string_view what, std::uint64_t done, std::uint64_t total) const {
  if (listener_ != nullptr) listener_->progress(what, done, total);
}

void RunContext::check_stop() const {
  if (stop_ != nullptr && stop_->requested())
    throw Error(ErrorCode::cancelled, "interrupted").hint("Run the same command again to resume");
}

void RunContext::check_memory(std::uint64_t bytes, std::string_view what) const {
  if (memory_limit_bytes == 0) return;
  const std::uint64_t used = resident_bytes();
  if (used + bytes <= memory_limit_bytes) return;
  throw Error(ErrorCode::resource_exhausted, "memory limit would be passed by " + std::string(what))
      .found(std::to_string((used + bytes) >> 20) + " MiB")
      .allowed(std::to_string(memory_limit_bytes >> 20) + " MiB")
      .hint("Raise --memory-limit or cut the input into tiles");
}

}  // namespace cairn::base
