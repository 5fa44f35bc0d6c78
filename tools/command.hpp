// One subcommand: declares its arguments, then runs.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/run_context.hpp"
#include "io/json.hpp"
#include "tools/arguments.hpp"

namespace cairn::tools {

// What a command gives back. `summary` is printed with --json, `text` otherwise; both to stdout.
struct CommandResult {
  io::Json summary;
  std::string text;
  base::ExitCode exit_code = base::ExitCode::ok;
};

class Command {
 public:
  virtual ~Command() = default;
  // Contract: opens no file, does no work.
  virtual void declare(Arguments& arguments) = 0;
  // Existence and content of inputs are checked here. Throws base::Error.
  virtual CommandResult run(const Arguments& arguments, base::RunContext& ctx) = 0;
};

// The main function of the program cairn-<name>: parses, sets threads, signals and progress up, runs,
// prints, and maps errors to exit codes. The only place that prints errors.
int run_command(std::string_view name, std::string_view summary, Command& command, int argc, const char* const* argv);

// "4GiB", "512MiB", "2G", "1000000" -> bytes. Throws invalid_argument.
[[nodiscard]] std::uint64_t parse_bytes(std::string_view text);

}  // namespace cairn::tools

// Every cmd_<name>.cpp ends with this; CAIRN_COMMAND_NAME and _SUMMARY come from tools/CMakeLists.txt,
// where the registry stands.
#define CAIRN_COMMAND_MAIN(CommandType)                                                               \
  int main(int argc, char** argv) {                                                                   \
    CommandType command;                                                                              \
    return cairn::tools::run_command(CAIRN_COMMAND_NAME, CAIRN_COMMAND_SUMMARY, command, argc, argv); \
  }
