// What a stage may ask of its surroundings: log, progress, stop, seed, memory budget.
// Passed explicitly; library code never prints and never exits.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/random.hpp"

namespace cairn::base {

enum class LogLevel { debug, info, warning };

// Receives messages and progress. The command line installs one that writes to stderr;
// tests may collect.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual void message(LogLevel level, std::string_view text) = 0;
  // done <= total, both in items of `what` ("frames", "facets"); total 0 = not known.
  virtual void progress(std::string_view what, std::uint64_t done, std::uint64_t total) = 0;
};

// Set by a signal handler, or by a test; read by loops. Lock-free.
class StopFlag {
 public:
  void request() noexcept { requested_.store(true); }
  [[nodiscard]] bool requested() const noexcept { return requested_.load(); }

 private:
  std::atomic<bool> requested_{false};
};

class RunContext {
 public:
  // No listener: silent, for tests and nested calls.
  RunContext() = default;
  RunContext(Listener* listener, const StopFlag* stop) : listener_(listener), stop_(stop) {}

  std::uint64_t seed = 0;
  // 0 = no limit [bytes]; stages that would pass it throw resource_exhausted before they try.
  std::uint64_t memory_limit_bytes = 0;

  void debug(std::string_view text) const;
  void info(std::string_view text) const;
  // Warnings are also kept for run.json.
  void warn(std::string_view text);
  [[nodiscard]] const std::vector<std::string>& warnings() const noexcept { return warnings_; }

  void progress(std::string_view what, std::uint64_t done, std::uint64_t total) const;

  // Throws Error{cancelled} once a stop was requested. Call between items.
  void check_stop() const;
  // Throws Error{resource_exhausted} where `bytes` more would pass the limit.
  void check_memory(std::uint64_t bytes, std::string_view what) const;

  [[nodiscard]] Random random(std::string_view stage, std::uint64_t record) const {
    return Random(seed, stage, record);
  }

 private:
  Listener* listener_ = nullptr;
  const StopFlag* stop_ = nullptr;
  std::vector<std::string> warnings_;
};

}  // namespace cairn::base
