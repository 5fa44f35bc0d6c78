#include "tools/arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

using ::testing::HasSubstr;

struct Fixture {
  Arguments arguments{"locate", "Locates"};
  std::filesystem::path survey, output;
  double range_m = 2.0;
  bool merge = true;
  std::string mode = "robust", answer;

  Fixture() {
    arguments.input("survey", survey, "Survey folder");
    arguments.output(output, "Result");
    arguments.option("range-m", range_m, "Range");
    arguments.flag("merge", merge, "Merge");
    arguments.choice("mode", mode, {"paper", "robust"}, "Mode");
  }
  Arguments::Parsed parse(std::vector<const char*> words) {
    words.insert(words.begin(), "cairn-locate");
    return arguments.parse(static_cast<int>(words.size()), words.data(), answer);
  }
};

TEST(Arguments, PositionalsOptionsAndFlags) {
  Fixture f;
  EXPECT_EQ(f.parse({"s", "-o", "out", "--range-m", "-3.5", "--no-merge", "--mode=paper", "--threads", "2"}),
            Arguments::Parsed::run);
  EXPECT_EQ(f.survey, "s");
  EXPECT_EQ(f.output, "out");
  EXPECT_EQ(f.range_m, -3.5);
  EXPECT_FALSE(f.merge);
  EXPECT_EQ(f.mode, "paper");
  EXPECT_EQ(f.arguments.common.threads, 2);
}

TEST(Arguments, CommandLineBeatsEnvironmentBeatsConfigBeatsDefault) {
  const cairn::testing::TempFolder folder;
  base::write_file(folder / "c.json", R"({"range-m": 5.0, "mode": "paper", "merge": false})");
  ::setenv("CAIRN_LOCATE_MODE", "robust", 1);
  ::setenv("CAIRN_LOCATE_RANGE_M", "7", 1);
  Fixture f;
  const std::string config = (folder / "c.json").string();
  f.parse({"s", "-o", "out", "--config", config.c_str(), "--range-m", "9"});
  ::unsetenv("CAIRN_LOCATE_MODE");
  ::unsetenv("CAIRN_LOCATE_RANGE_M");
  EXPECT_EQ(f.range_m, 9.0);
  EXPECT_EQ(f.mode, "robust");
  EXPECT_FALSE(f.merge);
  const auto resolved = f.arguments.resolved(true);
  EXPECT_EQ(resolved.at("range-m").at("source").as_string(), "command line");
  EXPECT_EQ(resolved.at("mode").at("source").as_string(), "environment");
  EXPECT_EQ(resolved.at("merge").at("source").as_string(), "config");
  EXPECT_EQ(resolved.at("threads").at("source").as_string(), "default");
}

TEST(Arguments, MistakesAreUsageErrors) {
  for (const auto& words : std::vector<std::vector<const char*>>{{"-o", "out"},
                                                                 {"s"},
                                                                 {"s", "-o", "out", "--mode", "other"},
                                                                 {"s", "-o", "out", "--range-m", "wide"},
                                                                 {"s", "-o", "out", "--nonsense"},
                                                                 {"s", "t", "-o", "out"},
                                                                 {"s", "-o", "out", "--threads", "-1"}}) {
    Fixture f;
    try {
      f.parse(words);
      FAIL() << words.size();
    } catch (const base::Error& e) {
      EXPECT_EQ(e.code(), base::ErrorCode::invalid_argument);
    }
  }
}

TEST(Arguments, HelpAndUsageNameEveryOption) {
  Fixture f;
  EXPECT_EQ(f.parse({"--help"}), Arguments::Parsed::done);
  for (const auto* name : {"--range-m", "--mode", "--overwrite", "--threads", "-o,--output"})
    EXPECT_THAT(f.answer, HasSubstr(name));
  Fixture g;
  EXPECT_EQ(g.parse({"--json-usage"}), Arguments::Parsed::done);
  EXPECT_EQ(io::parse_json(g.answer, "usage").at("command").as_string(), "locate");
}

TEST(ParseBytes, UnitsAndNonsense) {
  EXPECT_EQ(parse_bytes("4GiB"), std::uint64_t{4} << 30);
  EXPECT_EQ(parse_bytes("1.5M"), std::uint64_t{3} << 19);
  EXPECT_EQ(parse_bytes("1000"), 1000U);
  for (const auto* text : {"", "GiB", "-1M", "many", "1e30"})
    EXPECT_THROW((void)parse_bytes(text), base::Error) << text;
}

}  // namespace
}  // namespace cairn::tools
