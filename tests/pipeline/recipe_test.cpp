#include "pipeline/recipe.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::pipeline {
namespace {

Recipe parse(const std::string& text) {
  const cairn::testing::TempFolder folder;
  base::write_file(folder / "r.json", text);
  return read_recipe(folder / "r.json");
}

TEST(Recipe, ReadsStagesAndOptions) {
  const Recipe r = parse(R"({"schema_version": 1, "name": "post_flight", "stages":
      [{"stage": "locate", "options": {"mode": "paper", "points": 500, "merge": false}}, {"stage": "report"}]})");
  ASSERT_EQ(r.stages.size(), 2U);
  EXPECT_EQ(r.stages[0].options[0], (std::pair<std::string, std::string>("mode", "paper")));
  EXPECT_EQ(r.stages[0].options[1].second, "500");
  EXPECT_EQ(r.stages[0].options[2].second, "false");
}

TEST(Recipe, SettingsReplaceOptions) {
  Recipe r =
      parse(R"({"schema_version": 1, "name": "x", "stages": [{"stage": "locate", "options": {"points": 500}}]})");
  apply_setting(r, "locate.points=700");
  apply_setting(r, "locate.mode=paper");
  EXPECT_EQ(r.stages[0].options.size(), 2U);
  EXPECT_EQ(r.stages[0].options[0].second, "700");
  EXPECT_THROW(apply_setting(r, "segment.x=1"), base::Error);
  EXPECT_THROW(apply_setting(r, "locate.points"), base::Error);
}

TEST(Recipe, NamesWhatIsWrong) {
  for (const auto* text :
       {R"({"name": "x", "stages": []})", R"({"schema_version": 2, "name": "x", "stages": []})",
        R"({"schema_version": 1, "name": "x", "stages": []})", R"({"schema_version": 1, "name": "x", "stges": []})"}) {
    try {
      (void)parse(text);
      FAIL() << text;
    } catch (const base::Error& e) {
      EXPECT_EQ(e.code(), base::ErrorCode::invalid_input);
      EXPECT_THAT(e.file(), ::testing::EndsWith("r.json"));
    }
  }
}

}  // namespace
}  // namespace cairn::pipeline
