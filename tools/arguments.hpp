// The arguments of one subcommand: declared once, then parsed, documented, completed and printed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "base/options.hpp"
#include "io/json.hpp"

namespace cairn::tools {

// What every subcommand understands.
struct CommonOptions {
  bool json = false;
  bool quiet = false;
  bool verbose = false;
  std::string progress = "auto";  // auto, none, json
  std::int64_t threads = 0;       // 0 = all cores
  std::int64_t seed = 0;
  std::string memory_limit;  // "4GiB"; "" = none
  std::filesystem::path config;
  bool print_config = false;
  bool dry_run = false;
  bool overwrite = false;
};

// Declares where values go; opens no file and does no work. Every value can also come from the
// environment (CAIRN_<COMMAND>_<OPTION>) or from --config; precedence: command line, environment,
// config, default.
class Arguments {
 public:
  Arguments(std::string_view command, std::string_view summary);
  ~Arguments();
  Arguments(const Arguments&) = delete;
  Arguments& operator=(const Arguments&) = delete;

  // Positional arguments, in this order. A positional also has its name as an option: --survey PATH.
  void input(std::string_view name, std::filesystem::path& value, std::string_view help, bool required = true);
  void inputs(std::string_view name, std::vector<std::filesystem::path>& values, std::string_view help);
  void word(std::string_view name, std::string& value, const std::vector<std::string>& allowed, std::string_view help);
  // -o, --output.
  void output(std::filesystem::path& value, std::string_view help, bool required = true);

  // Named options, kebab-case without the dashes, units in the name.
  void option(std::string_view name, double& value, std::string_view help);
  void option(std::string_view name, std::int64_t& value, std::string_view help);
  void option(std::string_view name, std::string& value, std::string_view help);
  void option(std::string_view name, std::filesystem::path& value, std::string_view help);
  // May be given many times.
  void option(std::string_view name, std::vector<std::string>& values, std::string_view help);
  void flag(std::string_view name, bool& value, std::string_view help);
  void choice(std::string_view name, std::string& value, const std::vector<std::string>& allowed,
              std::string_view help);
  // All options of an algorithm's options struct.
  void options(const base::VisitOptions& visit);

  // Shown at the end of --help.
  void example(std::string_view line);

  CommonOptions common;

  enum class Parsed { run, done };
  // Throws Error{invalid_argument}. `done`: --help, --version, --json-usage or --print-config was
  // answered; the text for stdout is in `answer`.
  Parsed parse(int argc, const char* const* argv, std::string& answer);

  // Name, value and where it came from of every option: what --print-config and run.json show.
  [[nodiscard]] io::Json resolved(bool with_source) const;
  // Options with kind, default and help, for completion and documentation.
  [[nodiscard]] io::Json usage() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::tools
