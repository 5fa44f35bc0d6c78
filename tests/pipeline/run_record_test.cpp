#include "pipeline/run_record.hpp"

#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"

namespace cairn::pipeline {
namespace {

namespace fs = std::filesystem;

Outcome write_one(const fs::path& folder) {
  base::write_file(folder / "product.txt", "x");
  return {io::Json::object({{"count", 1}}), {{"target 3", "too_few_points", "7 points, 30 needed"}}};
}

TEST(RunToFolder, PublishesProductsAndRunJsonTogether) {
  const cairn::testing::TempFolder folder;
  base::RunContext ctx;
  run_to_folder(folder / "out", false, {"test", {}, 0, {}, {}, {}, {}, {}}, write_one, ctx);
  const auto run = io::read_json(folder / "out" / fs::path("run.json"));
  EXPECT_EQ(run.at("command").as_string(), "test");
  EXPECT_EQ(run.at("rejects_by_reason").at("too_few_points").as_integer(), 1);
  EXPECT_EQ(run.at("summary").at("count").as_integer(), 1);
}

TEST(RunToFolder, LeavesNothingWhenTheStageFails) {
  const cairn::testing::TempFolder folder;
  base::RunContext ctx;
  EXPECT_THROW(run_to_folder(
                   folder / "out", false, {"test", {}, 0, {}, {}, {}, {}, {}},
                   [](const fs::path& staged) -> Outcome {
                     base::write_file(staged / "half.txt", "x");
                     throw base::Error(base::ErrorCode::invalid_input, "bad");
                   },
                   ctx),
               base::Error);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(RunToFolder, NeverReplacesWhatCairnDidNotMake) {
  const cairn::testing::TempFolder folder;
  base::RunContext ctx;
  fs::create_directory(folder / "mine");
  base::write_file(folder / "mine" / fs::path("thesis.txt"), "years of work");
  EXPECT_THROW(run_to_folder(folder / "mine", true, {"test", {}, 0, {}, {}, {}, {}, {}}, write_one, ctx), base::Error);
  EXPECT_TRUE(fs::exists(folder / "mine" / fs::path("thesis.txt")));

  run_to_folder(folder / "out", false, {"test", {}, 0, {}, {}, {}, {}, {}}, write_one, ctx);
  EXPECT_THROW(run_to_folder(folder / "out", false, {"test", {}, 0, {}, {}, {}, {}, {}}, write_one, ctx), base::Error);
  EXPECT_NO_THROW(run_to_folder(folder / "out", true, {"test", {}, 0, {}, {}, {}, {}, {}}, write_one, ctx));
}

TEST(DigestInputs, DependsOnContentAndNameNotOnPlace) {
  const cairn::testing::TempFolder a, b;
  for (const auto* f : {&a, &b}) {
    base::write_file(*f / "one", "1");
    base::write_file(*f / "two", "2");
  }
  EXPECT_EQ(combined_digest(digest_inputs({a.path()})), combined_digest(digest_inputs({b.path()})));
  base::write_file(b / "two", "3");
  EXPECT_NE(combined_digest(digest_inputs({a.path()})), combined_digest(digest_inputs({b.path()})));
  EXPECT_THROW((void)digest_inputs({a / "none"}), base::Error);
}

}  // namespace
}  // namespace cairn::pipeline
