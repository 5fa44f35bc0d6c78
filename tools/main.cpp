// The starter: lists the subcommands, and becomes the program of the one that was asked for.
// It links nothing heavy, so `cairn --version` and `cairn --help` answer in milliseconds
// (docs/decisions/0001-one-program-a-subcommand.md).
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/version.hpp"
#include "tools/completion.hpp"
#include "tools/registry.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::tools::registry;

constexpr int kUsage = 2;
constexpr int kProcessingError = 1;

void print_help(std::FILE* stream) {
  std::fprintf(stream,
               "cairn %.*s: offline processing of drone surveys: rocks, obstacles, coverage, routes\n\n"
               "Usage: cairn <subcommand> INPUT... -o OUTPUT [--options]\n\nSubcommands:\n",
               static_cast<int>(cairn::base::kVersion.size()), cairn::base::kVersion.data());
  for (const auto& entry : registry())
    std::fprintf(stream, "  %-11.*s %.*s\n", static_cast<int>(entry.name.size()), entry.name.data(),
                 static_cast<int>(entry.summary.size()), entry.summary.data());
  std::fputs(
      "\n  cairn <subcommand> --help   options and examples\n"
      "  cairn --version             version\n"
      "  cairn completion bash       completion script for the shell\n",
      stream);
}

std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, change});
    }
  }
  return row[b.size()];
}

int unknown(std::string_view name) {
  std::fprintf(stderr, "cairn: error: unknown subcommand '%.*s'", static_cast<int>(name.size()), name.data());
  for (const auto& entry : registry())
    if (distance(name, entry.name) <= 2)
      std::fprintf(stderr, "; did you mean '%.*s'?", static_cast<int>(entry.name.size()), entry.name.data());
  std::fputs("\nSee 'cairn --help'\n", stderr);
  return kUsage;
}

int start(std::string_view name, char** argv) {
  std::error_code code;
  const fs::path self = fs::read_symlink("/proc/self/exe", code);
  if (code) {
    std::fprintf(stderr, "cairn: error: cannot find the program's own folder: %s\n", code.message().c_str());
    return kProcessingError;
  }
  const fs::path program = self.parent_path().parent_path() / "libexec/cairn" / ("cairn-" + std::string(name));
  ::execv(program.c_str(), argv);
  std::fprintf(stderr, "cairn: error: cannot start %s: %s. Build or install cairn again\n", program.c_str(),
               std::strerror(errno));
  return kProcessingError;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string_view name = argc > 1 ? argv[1] : "";
  if (name.empty()) {
    print_help(stderr);
    return kUsage;
  }
  if (name == "--help" || name == "-h") {
    print_help(stdout);
    return 0;
  }
  if (name == "--version") {
    std::printf("cairn %.*s\n", static_cast<int>(cairn::base::kVersion.size()), cairn::base::kVersion.data());
    return 0;
  }
  if (name == "completion") {
    if (argc != 3 || std::string_view(argv[2]) != "bash") {
      std::fputs("cairn: error: usage: cairn completion bash\n", stderr);
      return kUsage;
    }
    std::fputs(cairn::tools::bash_completion().c_str(), stdout);
    return 0;
  }
  for (const auto& entry : registry()) {
    if (entry.name == name) return start(name, argv + 1);
    if (name == "help" && argc > 2 && entry.name == argv[2]) {
      char help[] = "--help";
      char* arguments[] = {argv[2], help, nullptr};
      return start(entry.name, arguments);
    }
  }
  if (name == "help") {
    print_help(stdout);
    return 0;
  }
  return unknown(name);
}
