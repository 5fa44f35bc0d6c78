#include "pipeline/executor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;

// Two stages: `first` writes its factor, `second` adds to what first wrote.
struct Counts {
  int first = 0, second = 0;
  bool second_fails = false;
  bool first_lacks = false;
};

class First final : public Stage {
 public:
  explicit First(Counts& counts) : counts_(counts) {}
  [[nodiscard]] std::string_view name() const override { return "first"; }
  [[nodiscard]] std::string missing(const StageInputs&) const override { return counts_.first_lacks ? "boxes" : ""; }
  [[nodiscard]] base::VisitOptions options() override {
    return [this](base::OptionVisitor& v) { v.integer("factor", factor_, 0, 100, "a factor"); };
  }
  [[nodiscard]] Estimate estimate(const StageInputs&) const override { return {1, 2}; }
  Outcome run(const StageInputs&, const fs::path& out, base::RunContext& ctx) override {
    ++counts_.first;
    ctx.warn("first warns");
    base::write_file(out / "first.txt", std::to_string(factor_));
    return {io::Json::object({{"factor", factor_}}), {}};
  }

 private:
  Counts& counts_;
  std::int64_t factor_ = 7;
};

class Second final : public Stage {
 public:
  explicit Second(Counts& counts) : counts_(counts) {}
  [[nodiscard]] std::string_view name() const override { return "second"; }
  [[nodiscard]] std::vector<std::string> needs() const override { return {"first"}; }
  [[nodiscard]] base::VisitOptions options() override {
    return [](base::OptionVisitor&) {};
  }
  [[nodiscard]] Estimate estimate(const StageInputs&) const override { return {}; }
  Outcome run(const StageInputs& in, const fs::path& out, base::RunContext&) override {
    ++counts_.second;
    if (counts_.second_fails) throw base::Error(base::ErrorCode::resource_exhausted, "disk full");
    fs::create_directory(out / "rocks");
    base::write_file(out / "rocks" / "1.txt", base::read_file(in.products / "first.txt") + "!");
    return {io::Json::object(), {}};
  }

 private:
  Counts& counts_;
};

class ExecutorTest : public ::testing::Test {
 protected:
  Counts counts_;
  cairn::testing::TempFolder folder_;
  Recipe recipe_{"test", "", {{"first", {}}, {"second", {}}}};
  std::vector<InputDigest> inputs_{{"a", "00", 1}};
  ExecuteOptions options_{"survey", folder_ / "out", false, false, {}};

  ExecuteReport run() {
    base::RunContext ctx;
    return execute(
        recipe_,
        [this](std::string_view name) -> std::unique_ptr<Stage> {
          if (name == "first") return std::make_unique<First>(counts_);
          if (name == "second") return std::make_unique<Second>(counts_);
          return nullptr;
        },
        inputs_, options_, ctx);
  }
  [[nodiscard]] fs::path out(const char* name) const { return options_.out / name; }
};

TEST_F(ExecutorTest, SecondRunDoesNothing) {
  EXPECT_FALSE(run().nothing_to_do);
  EXPECT_EQ(base::read_file(out("rocks/1.txt")), "7!");
  EXPECT_TRUE(fs::exists(out("run.json")));
  const ExecuteReport again = run();
  EXPECT_TRUE(again.nothing_to_do);
  EXPECT_EQ(counts_.first, 1);
  EXPECT_EQ(counts_.second, 1);
}

TEST_F(ExecutorTest, ResumesAfterAFailure) {
  counts_.second_fails = true;
  EXPECT_THROW(run(), base::Error);
  EXPECT_FALSE(fs::exists(out("run.json")));
  EXPECT_FALSE(fs::exists(out("rocks")));
  counts_.second_fails = false;
  run();
  EXPECT_EQ(counts_.first, 1) << "a finished stage ran again";
  EXPECT_TRUE(fs::exists(out("run.json")));
}

TEST_F(ExecutorTest, ADamagedProductIsMadeAgainAndOnlyThat) {
  run();
  base::write_file(out("rocks/1.txt"), "damaged");
  run();
  EXPECT_EQ(base::read_file(out("rocks/1.txt")), "7!");
  EXPECT_EQ(counts_.first, 1);
  EXPECT_EQ(counts_.second, 2);
}

TEST_F(ExecutorTest, ATruncatedRecordMeansRunAgain) {
  run();
  base::write_file(out(".cairn/second.json"), "{\"key\": \"ab");
  run();
  EXPECT_EQ(counts_.second, 2);
}

TEST_F(ExecutorTest, AnotherJobNeedsOverwrite) {
  run();
  inputs_[0].sha256 = "01";
  try {
    run();
    FAIL();
  } catch (const base::Error& e) {
    EXPECT_EQ(e.code(), base::ErrorCode::already_exists);
  }
  options_.overwrite = true;
  run();
  EXPECT_EQ(counts_.first, 2);
}

TEST_F(ExecutorTest, AChangedOptionReachesWhatReadsItsProducts) {
  run();
  options_.overwrite = true;
  apply_setting(recipe_, "first.factor=9");
  run();
  EXPECT_EQ(base::read_file(out("rocks/1.txt")), "9!");
}

TEST_F(ExecutorTest, AShorterRecipeRemovesTheOtherStagesProducts) {
  run();
  options_.overwrite = true;
  recipe_.stages.pop_back();
  run();
  EXPECT_FALSE(fs::exists(out("rocks/1.txt")));
  EXPECT_TRUE(fs::exists(out("first.txt")));
}

TEST_F(ExecutorTest, FoldersOfOthersAreLeftAlone) {
  fs::create_directory(options_.out);
  base::write_file(out("thesis.txt"), "x");
  options_.overwrite = true;
  EXPECT_THROW(run(), base::Error);
  EXPECT_TRUE(fs::exists(out("thesis.txt")));
}

TEST_F(ExecutorTest, DryRunWritesNothing) {
  options_.dry_run = true;
  const ExecuteReport report = run();
  EXPECT_EQ(report.stages.size(), 2U);
  EXPECT_EQ(report.stages[0].state, "would run");
  EXPECT_EQ(report.stages[0].estimate.disk_bytes, 2U);
  EXPECT_FALSE(fs::exists(options_.out));
}

TEST_F(ExecutorTest, RecipesThatCannotWorkAreRefused) {
  recipe_.stages = {{"second", {}}};
  EXPECT_THROW(run(), base::Error);
  recipe_.stages = {{"first", {}}, {"first", {}}};
  EXPECT_THROW(run(), base::Error);
  recipe_.stages = {{"third", {}}};
  EXPECT_THROW(run(), base::Error);
  recipe_.stages = {{"first", {{"factor", "1000"}}}};
  EXPECT_THROW(run(), base::Error);
  EXPECT_EQ(counts_.first, 0);
}

// An optional stage is left out where the survey lacks what it works on, and its products with it.
TEST_F(ExecutorTest, OptionalStagesAreLeftOut) {
  recipe_.stages = {{"first", {}, true}};
  EXPECT_EQ(run().stages.at(0).state, "ran");
  EXPECT_TRUE(fs::exists(options_.out / "first.txt"));
  counts_.first_lacks = true;
  EXPECT_EQ(run().stages.at(0).state, "skipped: no boxes");
  EXPECT_FALSE(fs::exists(options_.out / "first.txt"));
  EXPECT_TRUE(fs::exists(options_.out / "run.json"));
  counts_.first_lacks = false;
  EXPECT_EQ(run().stages.at(0).state, "ran");
  // Not optional: it is never asked what it lacks.
  counts_.first_lacks = true;
  recipe_.stages = {{"first", {}, false}};
  options_.overwrite = true;
  EXPECT_EQ(run().stages.at(0).state, "kept");
}

}  // namespace
}  // namespace cairn::pipeline
