#include "tools/command.hpp"

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#include "base/number_text.hpp"
#include "base/parallel.hpp"
#include "tools/terminal.hpp"

namespace cairn::tools {
namespace {

base::StopFlag& stop_flag() {
  static base::StopFlag flag;
  return flag;
}

extern "C" void on_signal(int number) {
  // A second signal ends the program at once.
  stop_flag().request();
  std::signal(number, SIG_DFL);
}

io::Json error_json(const base::Error& e) {
  io::Json json = io::Json::object({{"code", base::name_of(e.code())}, {"message", e.message()}});
  const std::pair<const char*, const std::string&> fields[] = {
      {"file", e.file()}, {"record", e.record()}, {"found", e.found()}, {"allowed", e.allowed()}, {"hint", e.hint()}};
  for (const auto& [name, value] : fields)
    if (!value.empty()) json.set(name, value);
  return json;
}

int report(std::string_view name, bool json, const base::Error& e) {
  const int code = static_cast<int>(base::exit_code(e.code()));
  std::fprintf(stderr, "cairn %.*s: error: %s\n", static_cast<int>(name.size()), name.data(), e.what());
  if (json) {
    try {
      print_out(io::Json::object({{"error", error_json(e)}, {"exit_code", code}}).dump(2) + "\n");
    } catch (const base::Error&) {
      // Nobody can read stdout; the message is on stderr and the code tells the rest.
    }
  }
  return code;
}

}  // namespace

std::uint64_t parse_bytes(std::string_view text) {
  const std::string_view all = text;
  constexpr std::pair<std::string_view, std::uint64_t> kUnits[] = {{"KiB", 1ULL << 10},
                                                                   {"MiB", 1ULL << 20},
                                                                   {"GiB", 1ULL << 30},
                                                                   {"K", 1ULL << 10},
                                                                   {"M", 1ULL << 20},
                                                                   {"G", 1ULL << 30},
                                                                   {"B", 1}};
  std::uint64_t unit = 1;
  for (const auto& [suffix, factor] : kUnits)
    if (text.ends_with(suffix)) {
      unit = factor;
      text.remove_suffix(suffix.size());
      break;
    }
  const auto value = base::parse_real(text);
  if (!value || !(*value > 0.0) || *value * static_cast<double>(unit) > 1e15)
    throw base::Error(base::ErrorCode::invalid_argument, "not an amount of memory")
        .found("'" + std::string(all) + "'")
        .allowed("a number with KiB, MiB or GiB, for example 4GiB");
  return static_cast<std::uint64_t>(*value * static_cast<double>(unit));
}

int run_command(std::string_view name, std::string_view summary, Command& command, int argc, const char* const* argv) {
  Arguments arguments(name, summary);
  // Known before parsing is over, so that a usage error is machine-readable too.
  bool json = false;
  for (int i = 1; i < argc; ++i) json = json || std::string_view(argv[i]) == "--json";
  Terminal terminal;
  try {
    command.declare(arguments);
    std::string answer;
    if (arguments.parse(argc, argv, answer) == Arguments::Parsed::done) {
      print_out(answer);
      return 0;
    }
    const CommonOptions& common = arguments.common;
    json = common.json;
    terminal.configure(common.quiet, common.verbose, common.progress);
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    std::signal(SIGPIPE, SIG_IGN);

    const base::ThreadLimit threads(static_cast<int>(common.threads));
    base::RunContext ctx(&terminal, &stop_flag());
    ctx.seed = static_cast<std::uint64_t>(common.seed);
    if (!common.memory_limit.empty()) ctx.memory_limit_bytes = parse_bytes(common.memory_limit);
    const CommandResult result = command.run(arguments, ctx);
    terminal.finish();
    if (json) print_out(result.summary.dump(2) + "\n");
    else if (!common.quiet) print_out(result.text);
    return static_cast<int>(result.exit_code);
  } catch (const base::Error& e) {
    terminal.finish();
    return report(name, json, e);
  } catch (const std::bad_alloc&) {
    terminal.finish();
    return report(name, json,
                  base::Error(base::ErrorCode::resource_exhausted, "out of memory")
                      .hint("Use --memory-limit, a smaller input, or a machine with more memory"));
  } catch (const std::exception& e) {
    terminal.finish();
    return report(name, json, base::Error(base::ErrorCode::internal, e.what()));
  }
}

}  // namespace cairn::tools
