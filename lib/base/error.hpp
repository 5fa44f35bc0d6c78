// Errors that abort a command, and the exit code each one maps to.
#pragma once

#include <exception>
#include <string>
#include <string_view>
#include <vector>

namespace cairn::base {

// Closed set. Pick by what the caller can do about it, not by where it happened.
enum class ErrorCode {
  invalid_argument,     // the command line or an option is wrong
  invalid_input,        // a file's content is wrong, truncated or hostile
  not_found,            // a file or record that was named does not exist
  already_exists,       // the output is there and --overwrite was not given
  resource_exhausted,   // memory limit, disk full, write error
  crs_mismatch,         // CRS, datum, unit, frame or grid problem
  failed_precondition,  // the inputs do not fit together
  quality_gate,         // finished, but a quality gate failed
  cancelled,            // interrupted; the work done so far can be resumed
  internal,             // a defect of cairn
};

// Exit codes of the command line (docs/exit_codes.md).
enum class ExitCode : int {
  ok = 0,
  processing_error = 1,
  usage = 2,
  item_failures = 3,
  invalid_input = 4,
  resource_limit = 5,
  crs_or_grid = 6,
  output_exists = 7,
  interrupted = 8,
  gate_failed = 9,
};

[[nodiscard]] ExitCode exit_code(ErrorCode code);
[[nodiscard]] std::string_view name_of(ErrorCode code);

// What went wrong, where, what was found, what would be allowed, and what to do.
// Build with the fluent setters; add context on the way up with `in()`.
class Error : public std::exception {
 public:
  Error(ErrorCode code, std::string message);

  // File (or stream) the error is about.
  Error&& file(std::string_view path) &&;
  // Record inside the file: "line 12", "frame DJI_0030", "byte 429".
  Error&& record(std::string_view record) &&;
  // The value found, and the values that would have been accepted.
  Error&& found(std::string_view value) &&;
  Error&& allowed(std::string_view values) &&;
  // The remedy, in the imperative.
  Error&& hint(std::string_view remedy) &&;

  // Context added by a caller on the way up: `catch (Error& e) { e.in("stage locate"); throw; }`
  void in(std::string_view context);
  // Sets the file only where none is known yet.
  void default_file(std::string_view path);

  [[nodiscard]] ErrorCode code() const noexcept { return code_; }
  [[nodiscard]] const std::string& message() const noexcept { return message_; }
  [[nodiscard]] const std::string& file() const noexcept { return file_; }
  [[nodiscard]] const std::string& record() const noexcept { return record_; }
  [[nodiscard]] const std::string& found() const noexcept { return found_; }
  [[nodiscard]] const std::string& allowed() const noexcept { return allowed_; }
  [[nodiscard]] const std::string& hint() const noexcept { return hint_; }
  [[nodiscard]] const std::vector<std::string>& context() const noexcept { return context_; }

  // One paragraph: "FILE, RECORD: message (found X; allowed Y). Do this. [while CONTEXT]"
  [[nodiscard]] const char* what() const noexcept override { return text_.c_str(); }

 private:
  void compose();

  ErrorCode code_;
  std::string message_, file_, record_, found_, allowed_, hint_;
  std::vector<std::string> context_;
  std::string text_;
};

}  // namespace cairn::base
