// What a check found, as a list that forgets nothing and repeats itself within bounds.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "io/json.hpp"

namespace cairn::pipeline {

// error: results would be wrong; warning: they may be; info: worth knowing.
enum class Severity { info, warning, error };
[[nodiscard]] std::string_view name_of(Severity severity);

struct Finding {
  std::string code;  // stable, snake_case; the table stands in docs/commands/check.md
  Severity severity = Severity::error;
  std::string file;     // the file that is wrong
  std::string record;   // where in it: "line 7, column qw (frame 12)"
  std::string message;  // what is wrong, with the value found and the values allowed
  std::string hint;     // what to do
};

class Findings {
 public:
  // More than `per_code` of one code are counted, not listed.
  explicit Findings(std::size_t per_code = 1000) : per_code_(per_code) {}

  void add(Finding finding);
  // From an error that would have aborted a command; `record` is used where the error has none.
  void add(std::string code, const base::Error& error, std::string_view record = {},
           Severity severity = Severity::error);

  [[nodiscard]] bool has(std::string_view code) const { return counts_.contains(std::string(code)); }
  [[nodiscard]] std::size_t count(Severity severity) const;
  // Errors first, then warnings, then info; otherwise in the order found; for each code cut short, one
  // more finding says how many are not listed.
  [[nodiscard]] std::vector<Finding> list() const;

 private:
  std::size_t per_code_;
  std::vector<Finding> findings_;
  std::map<std::string, std::size_t> counts_;
  std::map<std::string, Severity> severities_;
};

[[nodiscard]] io::Json to_json(const std::vector<Finding>& findings);

// "message (found F; allowed A)".
[[nodiscard]] std::string told(std::string_view message, std::string_view found, std::string_view allowed);

}  // namespace cairn::pipeline
