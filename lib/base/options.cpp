#include "base/options.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::base {
namespace {

std::string join(const std::vector<std::string>& items, std::string_view separator) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "" : std::string(separator)) + item;
  return text;
}

class Checker final : public OptionVisitor {
 public:
  std::vector<std::string> found;

  void real(std::string_view name, double& value, double lo, double hi, std::string_view) override {
    if (!(value >= lo && value <= hi)) report(name, to_text(value), to_text(lo) + " to " + to_text(hi));
  }
  void integer(std::string_view name, std::int64_t& value, std::int64_t lo, std::int64_t hi,
               std::string_view) override {
    if (value < lo || value > hi) report(name, std::to_string(value), std::to_string(lo) + " to " + std::to_string(hi));
  }
  void flag(std::string_view, bool&, std::string_view) override {}
  void choice(std::string_view name, std::string& value, const std::vector<std::string>& allowed,
              std::string_view) override {
    for (const auto& a : allowed)
      if (a == value) return;
    report(name, "'" + value + "'", join(allowed, ", "));
  }
  void text(std::string_view, std::string&, std::string_view) override {}

 private:
  void report(std::string_view name, const std::string& value, const std::string& allowed) {
    found.push_back(std::string(name) + " = " + value + " (allowed " + allowed + ")");
  }
};

class Setter final : public OptionVisitor {
 public:
  Setter(std::string_view name, std::string_view value) : name_(name), value_(value) {}
  bool done = false;
  std::vector<std::string> known;

  void real(std::string_view name, double& value, double, double, std::string_view) override {
    if (!match(name)) return;
    const auto parsed = parse_real(value_);
    if (!parsed) fail("a number");
    value = *parsed;
  }
  void integer(std::string_view name, std::int64_t& value, std::int64_t, std::int64_t, std::string_view) override {
    if (!match(name)) return;
    const auto parsed = parse_integer(value_);
    if (!parsed) fail("a whole number");
    value = *parsed;
  }
  void flag(std::string_view name, bool& value, std::string_view) override {
    if (!match(name)) return;
    if (value_ == "true" || value_ == "1" || value_ == "yes") value = true;
    else if (value_ == "false" || value_ == "0" || value_ == "no") value = false;
    else fail("true or false");
  }
  void choice(std::string_view name, std::string& value, const std::vector<std::string>& allowed,
              std::string_view) override {
    if (!match(name)) return;
    for (const auto& a : allowed)
      if (a == value_) {
        value = a;
        return;
      }
    fail(join(allowed, ", "));
  }
  void text(std::string_view name, std::string& value, std::string_view) override {
    if (match(name)) value = value_;
  }

 private:
  bool match(std::string_view name) {
    known.emplace_back(name);
    if (name != name_) return false;
    done = true;
    return true;
  }
  [[noreturn]] void fail(const std::string& allowed) {
    throw Error(ErrorCode::invalid_argument, "option '" + std::string(name_) + "' has a value of the wrong kind")
        .found("'" + std::string(value_) + "'")
        .allowed(allowed);
  }
  std::string_view name_, value_;
};

class Printer final : public OptionVisitor {
 public:
  std::vector<OptionText> texts;
  void real(std::string_view name, double& value, double, double, std::string_view) override {
    texts.push_back({std::string(name), to_text(value), false});
  }
  void integer(std::string_view name, std::int64_t& value, std::int64_t, std::int64_t, std::string_view) override {
    texts.push_back({std::string(name), std::to_string(value), false});
  }
  void flag(std::string_view name, bool& value, std::string_view) override {
    texts.push_back({std::string(name), value ? "true" : "false", false});
  }
  void choice(std::string_view name, std::string& value, const std::vector<std::string>&, std::string_view) override {
    texts.push_back({std::string(name), value, true});
  }
  void text(std::string_view name, std::string& value, std::string_view) override {
    texts.push_back({std::string(name), value, true});
  }
};

}  // namespace

std::vector<std::string> problems(const VisitOptions& options) {
  Checker checker;
  options(checker);
  return checker.found;
}

void validate(const VisitOptions& options, std::string_view stage) {
  const auto found = problems(options);
  if (!found.empty())
    throw Error(ErrorCode::invalid_argument, "options of " + std::string(stage) + ": " + join(found, "; "));
}

void set_option(const VisitOptions& options, std::string_view name, std::string_view value) {
  Setter setter(name, value);
  options(setter);
  if (!setter.done)
    throw Error(ErrorCode::invalid_argument, "unknown option '" + std::string(name) + "'")
        .allowed(join(setter.known, ", "));
}

std::vector<OptionText> option_texts(const VisitOptions& options) {
  Printer printer;
  options(printer);
  return printer.texts;
}

}  // namespace cairn::base
