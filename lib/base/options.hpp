// One description of an options struct serves the command line, recipes, --print-config,
// validation and the docs.
//
// An options struct has public fields with commented defaults, and
//     void visit(base::OptionVisitor& visitor);
// that names each field once. `validate` and `to_text` below work on any such struct.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace cairn::base {

// Names are kebab-case and carry the unit: "max-range-m". Ranges are inclusive.
class OptionVisitor {
 public:
  virtual ~OptionVisitor() = default;
  virtual void real(std::string_view name, double& value, double lo, double hi, std::string_view help) = 0;
  virtual void integer(std::string_view name, std::int64_t& value, std::int64_t lo, std::int64_t hi,
                       std::string_view help) = 0;
  virtual void flag(std::string_view name, bool& value, std::string_view help) = 0;
  virtual void choice(std::string_view name, std::string& value, const std::vector<std::string>& allowed,
                      std::string_view help) = 0;
  virtual void text(std::string_view name, std::string& value, std::string_view help) = 0;
};

// A set of options, type-erased: what tools and pipeline pass around.
using VisitOptions = std::function<void(OptionVisitor&)>;

template <typename Options>
[[nodiscard]] VisitOptions bind_options(Options& options) {
  return [&options](OptionVisitor& visitor) { options.visit(visitor); };
}

// All problems at once; empty = valid. Each names the option, the value and the range.
[[nodiscard]] std::vector<std::string> problems(const VisitOptions& options);

// Throws Error{invalid_argument} with all problems where there are any.
void validate(const VisitOptions& options, std::string_view stage);

// Sets one option from text ("true", "0.25", "robust"). Throws invalid_argument for an
// unknown name (with the known ones) or a text that is not of the option's type.
void set_option(const VisitOptions& options, std::string_view name, std::string_view value);

// Name and value of each option, in order; reals in shortest round-trip form.
struct OptionText {
  std::string name, value;
  bool quoted = false;  // whether the value is text (JSON writers quote it)
};
[[nodiscard]] std::vector<OptionText> option_texts(const VisitOptions& options);

}  // namespace cairn::base
