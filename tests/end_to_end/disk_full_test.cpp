// A disk that fills up at any moment: exit 5, a message that names the file, nothing half-written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

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

TEST(DiskFull, AFolderThatCannotBeWrittenIsSaid) {
  const TempFolder in;
  cairn::testing::write_small_ground(in.path());
  const auto result = cairn({"costmap", "--obstacles", (in / "obstacles.json").string(), "--surface",
                             (in / "surface.tif").string(), "-o", "/proc/cairn/out"});
  EXPECT_EQ(result.exit_code, 5);
  EXPECT_THAT(result.err, HasSubstr("/proc/cairn"));
}

}  // namespace
