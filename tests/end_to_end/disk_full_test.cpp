// A disk that fills up at any moment: exit 5, a message that names the file, nothing half-written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/atomic_file.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"
#include "support/small_ground.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kMostWrites = 400;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
  return names;
}

// Runs the command with the n-th write failing, for n = 1, 2, ... until no write is left to fail.
// `out` is the only name the command may leave in `folder`.
void sweep(const std::vector<std::string>& arguments, const fs::path& folder, const fs::path& out) {
  for (int n = 1; n <= kMostWrites; ++n) {
    const TempFolder logs;
    const std::string log = (logs / "log").string();
    const auto result =
        cairn(arguments,
              {{"LD_PRELOAD", CAIRN_FAILING_WRITES}, {"CAIRN_FAIL_WRITE", std::to_string(n)}, {"CAIRN_FAIL_LOG", log}});
    if (!fs::exists(log)) {
      EXPECT_EQ(result.exit_code, 0) << result.err;
      EXPECT_TRUE(fs::exists(out));
      EXPECT_GT(n, 3) << "the shim saw too few writes to prove anything";
      return;
    }
    ASSERT_EQ(result.exit_code, 5) << "write " << n << ": " << result.err;
    EXPECT_THAT(result.err, HasSubstr("error: /")) << "write " << n << " names no file";
    EXPECT_FALSE(fs::exists(out)) << "write " << n;
    EXPECT_THAT(names_in(folder), IsEmpty()) << "write " << n << " left a temporary behind";
  }
  FAIL() << "more than " << kMostWrites << " writes";
}

TEST(DiskFull, CostmapLeavesNothingAtAnyWrite) {
  const TempFolder in, results;
  cairn::testing::write_small_ground(in.path());
  sweep({"costmap", "--obstacles", (in / "obstacles.json").string(), "--surface", (in / "surface.tif").string(), "-o",
         (results / "out").string()},
        results.path(), results / "out");
}

std::vector<std::string> import_arguments(const fs::path& to) {
  const auto in = cairn::testing::sample("brighton_beach");
  return {"import",
          "colmap",
          (in / "colmap_enu").string(),
          "--images",
          (in / "images_1600").string(),
          "--origin",
          "46.8426,-91.9940,158.0",
          "--height-type",
          "ellipsoidal",
          "--scale-images",
          "0.4",
          "--detections",
          (in / "detections.csv").string(),
          "-o",
          to.string()};
}

TEST(DiskFull, ImportLeavesNothingAtAnyWrite) {
  const TempFolder results;
  sweep(import_arguments(results / "survey"), results.path(), results / "survey");
}

std::map<std::string, std::string> products(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  if (!fs::exists(folder)) return contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = fs::relative(entry.path(), folder).string();
    if (entry.is_regular_file() && !name.starts_with(".cairn") && name != "run.json")
      contents[name] = cairn::base::read_file(entry.path());
  }
  return contents;
}

// A job may keep what was finished, for resuming; whatever stands under its final name is whole.
TEST(DiskFull, AJobKeepsWholeProductsOnlyAndResumes) {
  const TempFolder folder;
  const fs::path survey = folder / "survey", recipe = folder / "recipe.json";
  ASSERT_EQ(cairn(import_arguments(survey)).exit_code, 0);
  // Two files a target, points and a plot, would make hundreds of writes of one kind.
  cairn::base::write_file(recipe, R"({"schema_version": 1, "name": "small", "stages": [
      {"stage": "locate", "options": {"points": false, "plots": false}}]})");
  const auto run = [&](const fs::path& out, const std::map<std::string, std::string>& environment) {
    return cairn({"run", recipe.string(), survey.string(), "-o", out.string()}, environment);
  };
  ASSERT_EQ(run(folder / "reference", {}).exit_code, 0);
  const auto reference = products(folder / "reference");
  ASSERT_FALSE(reference.empty());

  const fs::path out = folder / "out";
  for (int n = 1; n <= kMostWrites; ++n) {
    const TempFolder logs;
    const std::string log = (logs / "log").string();
    std::error_code ignored;
    fs::remove_all(out, ignored);
    const auto result = run(
        out, {{"LD_PRELOAD", CAIRN_FAILING_WRITES}, {"CAIRN_FAIL_WRITE", std::to_string(n)}, {"CAIRN_FAIL_LOG", log}});
    if (!fs::exists(log)) {
      EXPECT_EQ(result.exit_code, 0) << result.err;
      EXPECT_GT(n, 3);
      return;
    }
    ASSERT_EQ(result.exit_code, 5) << "write " << n << ": " << result.err;
    EXPECT_FALSE(fs::exists(out / "run.json")) << "write " << n;
    for (const auto& [name, content] : products(out)) {
      ASSERT_TRUE(reference.contains(name)) << "write " << n << " left " << name;
      EXPECT_EQ(content, reference.at(name)) << "write " << n << ", " << name;
    }
    const auto resumed = run(out, {});
    ASSERT_EQ(resumed.exit_code, 0) << "write " << n << ": " << resumed.err;
    EXPECT_EQ(products(out), reference) << "write " << n;
  }
  FAIL() << "more than " << kMostWrites << " writes";
}

TEST(DiskFull, AFolderThatCannotBeWrittenIsSaid) {
  const TempFolder in;
  cairn::testing::write_small_ground(in.path());
  const auto result = cairn({"costmap", "--obstacles", (in / "obstacles.json").string(), "--surface",
                             (in / "surface.tif").string(), "-o", "/proc/cairn/out"});
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.err, HasSubstr("/proc/cairn"));
}

}  // namespace
