// The program `cairn` itself: version, help, completion, mistakes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "io/json.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

// Subcommands as the program lists them.
std::vector<std::string> listed() {
  const auto completion = cairn({"completion", "bash"}).out;
  const auto from = completion.find("compgen -W \"") + 12;
  std::vector<std::string> names;
  std::string name;
  for (std::size_t i = from; i < completion.size() && completion[i] != '"'; ++i) {
    if (completion[i] != ' ') {
      name += completion[i];
      continue;
    }
    if (name == "help") break;
    names.push_back(std::move(name));
    name.clear();
  }
  return names;
}

TEST(Starter, VersionAndHelp) {
  const auto version = cairn({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, StartsWith("cairn "));
  const auto help = cairn({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const auto& name : listed()) EXPECT_THAT(help.out, HasSubstr("\n  " + name));
  EXPECT_EQ(cairn({}).exit_code, 2);
  EXPECT_THAT(cairn({}).out, IsEmpty()) << "stdout is data";
}

TEST(Starter, SuggestsTheNearestSubcommand) {
  const auto result = cairn({"rnu"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("did you mean 'run'?"));
}

TEST(Starter, EverySubcommandHasHelpAPageAndATest) {
  ASSERT_FALSE(listed().empty());
  for (const auto& name : listed()) {
    const auto help = cairn({name, "--help"});
    EXPECT_EQ(help.exit_code, 0) << name << help.err;
    EXPECT_THAT(help.err, IsEmpty()) << name;
    EXPECT_TRUE(fs::exists(cairn::testing::source_dir() / "docs/commands" / (name + ".md"))) << name;
    EXPECT_TRUE(fs::exists(cairn::testing::source_dir() / "tests/cli" / name)) << name;
    const auto version = cairn({name, "--version"});
    EXPECT_EQ(version.out, cairn({"--version"}).out) << name;
    const auto usage = cairn::io::parse_json(cairn({name, "--json-usage"}).out, name);
    EXPECT_EQ(usage.at("command").as_string(), name);
  }
}

// A closed or full stdout is an error like any other, not a crash.
TEST(Starter, StdoutThatCannotBeWritten) {
  for (const auto* arguments : {"info no-such-file --json", "info --json-usage", "run --no-such-option --json"}) {
    const auto result =
        cairn::testing::run_program("/bin/sh", {"-c", std::string(CAIRN_PROGRAM) + " " + arguments + " > /dev/full"});
    EXPECT_GE(result.exit_code, 2) << arguments << result.err;
    EXPECT_LE(result.exit_code, 5) << arguments << result.err;
    EXPECT_THAT(result.err, HasSubstr("error")) << arguments;
  }
}

TEST(Starter, UnknownOptionsAreUsageErrorsInJsonToo) {
  for (const auto& name : listed()) {
    const auto result = cairn({name, "--no-such-option", "--json"});
    EXPECT_EQ(result.exit_code, 2) << name;
    EXPECT_EQ(cairn::io::parse_json(result.out, name).at("exit_code").as_integer(), 2);
    EXPECT_THAT(result.err, HasSubstr("--no-such-option"));
  }
}

}  // namespace
