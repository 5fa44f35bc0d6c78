#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <functional>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/version.hpp"
#include "tools/arguments.hpp"

namespace cairn::tools {
namespace {

using base::Error;
using base::ErrorCode;
using io::Json;

struct Entry {
  std::string name;
  std::string kind;  // path, text, number, integer, flag, list, choice
  std::string help;
  std::vector<std::string> allowed;
  bool positional = false;
  bool required = false;
  bool common = false;
  std::function<void(const std::string&)> set;  // from environment or config text
  std::function<Json()> get;
  std::function<bool()> empty;
  CLI::Option* option = nullptr;
  std::string source = "default";
  Json initial;
};

std::string join(const std::vector<std::string>& items) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "" : ", ") + item;
  return text;
}

[[noreturn]] void bad_value(const std::string& name, const std::string& found, const std::string& allowed) {
  throw Error(ErrorCode::invalid_argument, "option --" + name + " has a value it cannot take")
      .found("'" + found + "'")
      .allowed(allowed);
}

std::string environment_name(std::string_view command, std::string_view option) {
  std::string name = "CAIRN_" + std::string(command) + "_" + std::string(option);
  for (char& c : name) c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

std::string as_text(const Json& value) {
  if (value.is_string()) return value.as_string();
  return value.dump(0);
}

}  // namespace

struct Arguments::Impl {
  std::string command, summary;
  CLI::App app;
  std::vector<std::unique_ptr<Entry>> entries;
  std::vector<std::string> examples;
  bool version = false, json_usage = false, in_common = false;

  Impl(std::string_view c, std::string_view s) : command(c), summary(s), app(summary, "cairn " + command) {
    app.set_help_flag("");
  }

  Entry& add(std::string_view name, std::string_view kind, std::string_view help) {
    auto entry = std::make_unique<Entry>();
    entry->name = name;
    entry->kind = kind;
    entry->help = help;
    entry->common = in_common;
    entry->empty = [] { return false; };
    entries.push_back(std::move(entry));
    return *entries.back();
  }

  Entry& text_entry(std::string_view name, std::string& value, std::string_view help, const std::string& flags) {
    Entry& e = add(name, "text", help);
    e.set = [&value](const std::string& text) { value = text; };
    e.get = [&value] { return Json(value); };
    e.empty = [&value] { return value.empty(); };
    e.option = app.add_option(flags, value, e.help)->type_name("TEXT");
    return e;
  }

  Entry& path_entry(std::string_view name, std::filesystem::path& value, std::string_view help,
                    const std::string& flags) {
    Entry& e = add(name, "path", help);
    e.set = [&value](const std::string& text) { value = text; };
    e.get = [&value] { return Json(value.string()); };
    e.empty = [&value] { return value.empty(); };
    e.option = app.add_option_function<std::string>(
                      flags, [&value](const std::string& text) { value = text; }, e.help)
                   ->type_name("PATH");
    return e;
  }

  void number_entry(std::string_view name, double& value, std::string_view help) {
    Entry& e = add(name, "number", help);
    e.set = [&value, n = e.name](const std::string& text) {
      const auto parsed = base::parse_real(text);
      if (!parsed) bad_value(n, text, "a number");
      value = *parsed;
    };
    e.get = [&value] { return Json(value); };
    e.option = app.add_option_function<std::string>("--" + e.name, e.set, e.help)->type_name("NUMBER");
  }

  void integer_entry(std::string_view name, std::int64_t& value, std::string_view help) {
    Entry& e = add(name, "integer", help);
    e.set = [&value, n = e.name](const std::string& text) {
      const auto parsed = base::parse_integer(text);
      if (!parsed) bad_value(n, text, "a whole number");
      value = *parsed;
    };
    e.get = [&value] { return Json(value); };
    e.option = app.add_option_function<std::string>("--" + e.name, e.set, e.help)->type_name("INTEGER");
  }

  void flag_entry(std::string_view name, bool& value, std::string_view help, const std::string& flags) {
    Entry& e = add(name, "flag", help);
    e.set = [&value, n = e.name](const std::string& text) {
      if (text == "true" || text == "1") value = true;
      else if (text == "false" || text == "0") value = false;
      else bad_value(n, text, "true or false");
    };
    e.get = [&value] { return Json(value); };
    e.option = app.add_flag_callback(
        flags, [&value] { value = true; }, e.help);
    if (value) {
      // A flag that is on by default needs a way to be turned off.
      app.add_flag_callback("--no-" + e.name, [&value, &e] {
        value = false;
        e.source = "command line";
      });
    }
  }

  void choice_entry(std::string_view name, std::string& value, const std::vector<std::string>& allowed,
                    std::string_view help, bool positional) {
    Entry& e = add(name, "choice", help);
    e.allowed = allowed;
    e.positional = positional;
    e.set = [&value, allowed, n = e.name](const std::string& text) {
      if (std::find(allowed.begin(), allowed.end(), text) == allowed.end()) bad_value(n, text, join(allowed));
      value = text;
    };
    e.get = [&value] { return Json(value); };
    e.empty = [&value] { return value.empty(); };
    const std::string flags = positional ? e.name : "--" + e.name;
    e.option = app.add_option_function<std::string>(flags, e.set, e.help)->type_name("{" + join(allowed) + "}");
  }

  void list_entry(std::string_view name, std::vector<std::string>& values, std::string_view help) {
    Entry& e = add(name, "list", help);
    e.set = [&values](const std::string& text) { values.push_back(text); };
    e.get = [&values] { return Json(values); };
    e.option = app.add_option("--" + e.name, values, e.help)->type_name("TEXT");
  }
};

namespace {

// Options structs are bound here: each field becomes a command-line option whose default and range
// show in the help.
class Binder final : public base::OptionVisitor {
 public:
  explicit Binder(Arguments& arguments) : arguments_(arguments) {}
  void real(std::string_view name, double& value, double lo, double hi, std::string_view help) override {
    arguments_.option(name, value, with_range(help, base::to_text(value), base::to_text(lo), base::to_text(hi)));
  }
  void integer(std::string_view name, std::int64_t& value, std::int64_t lo, std::int64_t hi,
               std::string_view help) override {
    arguments_.option(name, value, with_range(help, std::to_string(value), std::to_string(lo), std::to_string(hi)));
  }
  void flag(std::string_view name, bool& value, std::string_view help) override {
    arguments_.flag(name, value, std::string(help) + (value ? " [on]" : " [off]"));
  }
  void choice(std::string_view name, std::string& value, const std::vector<std::string>& allowed,
              std::string_view help) override {
    arguments_.choice(name, value, allowed, std::string(help) + " [" + value + "]");
  }
  void text(std::string_view name, std::string& value, std::string_view help) override {
    arguments_.option(name, value, std::string(help) + (value.empty() ? "" : " [" + value + "]"));
  }

 private:
  static std::string with_range(std::string_view help, const std::string& value, const std::string& lo,
                                const std::string& hi) {
    return std::string(help) + " [" + value + "; " + lo + " to " + hi + "]";
  }
  Arguments& arguments_;
};

}  // namespace

Arguments::Arguments(std::string_view command, std::string_view summary)
    : impl_(std::make_unique<Impl>(command, summary)) {}
Arguments::~Arguments() = default;

void Arguments::input(std::string_view name, std::filesystem::path& value, std::string_view help, bool required) {
  Entry& e = impl_->path_entry(name, value, help, std::string(name) + ",--" + std::string(name));
  e.positional = true;
  e.required = required;
}

void Arguments::inputs(std::string_view name, std::vector<std::filesystem::path>& values, std::string_view help) {
  Entry& e = impl_->add(name, "list", help);
  e.positional = true;
  e.required = true;
  e.set = [&values](const std::string& text) { values.emplace_back(text); };
  e.get = [&values] {
    Json list = Json::array();
    for (const auto& v : values) list.push(v.string());
    return list;
  };
  e.empty = [&values] { return values.empty(); };
  e.option =
      impl_->app
          .add_option_function<std::vector<std::string>>(
              std::string(name),
              [&values](const std::vector<std::string>& texts) { values.assign(texts.begin(), texts.end()); }, e.help)
          ->type_name("PATH ...");
}

void Arguments::word(std::string_view name, std::string& value, const std::vector<std::string>& allowed,
                     std::string_view help) {
  impl_->choice_entry(name, value, allowed, help, true);
  impl_->entries.back()->required = true;
}

void Arguments::output(std::filesystem::path& value, std::string_view help, bool required) {
  Entry& e = impl_->path_entry("output", value, help, "-o,--output");
  e.required = required;
}

void Arguments::option(std::string_view name, double& value, std::string_view help) {
  impl_->number_entry(name, value, help);
}
void Arguments::option(std::string_view name, std::int64_t& value, std::string_view help) {
  impl_->integer_entry(name, value, help);
}
void Arguments::option(std::string_view name, std::string& value, std::string_view help) {
  impl_->text_entry(name, value, help, "--" + std::string(name));
}
void Arguments::option(std::string_view name, std::filesystem::path& value, std::string_view help) {
  impl_->path_entry(name, value, help, "--" + std::string(name));
}
void Arguments::option(std::string_view name, std::vector<std::string>& values, std::string_view help) {
  impl_->list_entry(name, values, help);
}
void Arguments::flag(std::string_view name, bool& value, std::string_view help) {
  impl_->flag_entry(name, value, help, "--" + std::string(name));
}
void Arguments::choice(std::string_view name, std::string& value, const std::vector<std::string>& allowed,
                       std::string_view help) {
  impl_->choice_entry(name, value, allowed, help, false);
}
void Arguments::options(const base::VisitOptions& visit) {
  Binder binder(*this);
  visit(binder);
}
void Arguments::example(std::string_view line) {
  impl_->examples.emplace_back(line);
}

Arguments::Parsed Arguments::parse(int argc, const char* const* argv, std::string& answer) {
  Impl& m = *impl_;
  m.in_common = true;
  m.flag_entry("json", common.json, "Machine-readable summary on stdout", "--json");
  m.flag_entry("quiet", common.quiet, "Errors only on stderr", "-q,--quiet");
  m.flag_entry("verbose", common.verbose, "More talk on stderr", "-v,--verbose");
  m.choice_entry("progress", common.progress, {"auto", "none", "json"},
                 "Progress on stderr: a bar on a terminal, nothing, or one JSON object a line [auto]", false);
  m.integer_entry("threads", common.threads, "Worker threads; results do not depend on it [0 = all cores]");
  m.integer_entry("seed", common.seed, "Seed of every random number [0]");
  m.text_entry("memory-limit", common.memory_limit, "Largest resident memory, for example 4GiB", "--memory-limit");
  m.path_entry("config", common.config, "JSON file with option values by name", "--config");
  m.flag_entry("print-config", common.print_config, "Print the resolved options and stop", "--print-config");
  m.flag_entry("dry-run", common.dry_run, "Check the inputs, print the plan, write nothing", "--dry-run");
  m.flag_entry("overwrite", common.overwrite, "Replace an output that exists", "--overwrite");
  bool help = false;
  for (CLI::Option* o :
       {m.app.add_flag("-h,--help", help, "This help"), m.app.add_flag("--version", m.version, "Version"),
        m.app.add_flag("--json-usage", m.json_usage, "All options as JSON")})
    o->group("Common");
  for (auto& entry : m.entries) {
    entry->initial = entry->get();
    entry->option->group(entry->common ? "Common" : (entry->positional ? "Positionals" : "Options"));
  }
  std::string footer;
  for (const auto& line : m.examples) footer += (footer.empty() ? "Examples:\n  " : "  ") + line + "\n";
  if (!footer.empty()) m.app.footer(footer);

  try {
    m.app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    throw Error(ErrorCode::invalid_argument, e.what()).hint("See 'cairn " + m.command + " --help'");
  }
  if (help) {
    answer = m.app.help();
    return Parsed::done;
  }
  if (m.version) {
    answer = "cairn " + std::string(base::kVersion) + "\n";
    return Parsed::done;
  }
  if (m.json_usage) {
    answer = usage().dump(2) + "\n";
    return Parsed::done;
  }

  for (auto& entry : m.entries)
    if (entry->option->count() > 0) entry->source = "command line";
  Json config = Json::object();
  if (!common.config.empty()) {
    config = io::read_json(common.config);
    for (const auto& [key, value] : config.as_object()) {
      const bool known =
          std::any_of(m.entries.begin(), m.entries.end(), [&k = key](const auto& e) { return e->name == k; });
      if (!known)
        throw Error(ErrorCode::invalid_argument, "unknown option '" + key + "'")
            .file(common.config.string())
            .hint("See 'cairn " + m.command + " --help'");
    }
  }
  for (auto& entry : m.entries) {
    if (entry->source == "command line" || entry->name == "config") continue;
    if (const char* text = std::getenv(environment_name(m.command, entry->name).c_str())) {
      entry->set(text);
      entry->source = "environment";
    } else if (const Json* value = config.find(entry->name)) {
      if (value->is_array())
        for (const auto& item : value->as_array()) entry->set(as_text(item));
      else entry->set(as_text(*value));
      entry->source = "config";
    }
  }
  if (common.print_config) {
    answer = resolved(true).dump(2) + "\n";
    return Parsed::done;
  }
  for (const auto& entry : m.entries)
    if (entry->required && entry->empty())
      throw Error(ErrorCode::invalid_argument,
                  entry->name == "output" ? "-o OUTPUT is missing" : "argument '" + entry->name + "' is missing")
          .hint("See 'cairn " + m.command + " --help'");
  if (common.threads < 0 || common.threads > 1024) bad_value("threads", std::to_string(common.threads), "0 to 1024");
  if (common.seed < 0) bad_value("seed", std::to_string(common.seed), "0 or more");
  return Parsed::run;
}

Json Arguments::resolved(bool with_source) const {
  Json list = Json::object();
  for (const auto& entry : impl_->entries) {
    if (entry->name == "print-config" || entry->name == "config") continue;
    list.set(entry->name,
             with_source ? Json::object({{"value", entry->get()}, {"source", entry->source}}) : entry->get());
  }
  return list;
}

Json Arguments::usage() const {
  Json list = Json::array();
  for (const auto& entry : impl_->entries) {
    Json item = Json::object({{"name", entry->name},
                              {"kind", entry->kind},
                              {"positional", entry->positional},
                              {"required", entry->required},
                              {"default", entry->initial},
                              {"help", entry->help}});
    if (!entry->allowed.empty()) item.set("allowed", Json(entry->allowed));
    list.push(std::move(item));
  }
  return Json::object({{"command", impl_->command}, {"summary", impl_->summary}, {"options", list}});
}

}  // namespace cairn::tools
