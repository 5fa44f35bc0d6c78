#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/atomic_file.hpp"
#include "io/cloud.hpp"
#include "io/json.hpp"
#include "support/data.hpp"
#include "support/run_program.hpp"
#include "support/small_rocks.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

class SegmentCommand : public ::testing::Test {
 protected:
  TempFolder folder_;
  std::string cloud_ = (folder_ / "cloud.las").string(), targets_ = (folder_ / "targets.json").string(),
              out_ = (folder_ / "labelled.las").string();
  void SetUp() override { ::cairn::testing::write_small_rocks(folder_.path()); }
};

TEST_F(SegmentCommand, LabelsRocksAndSaysWhyOthersAreNot) {
  const auto result = cairn({"segment", cloud_, "--targets", targets_, "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  EXPECT_EQ(summary.at("targets").as_integer(), 4);  // the tree is no rock
  EXPECT_EQ(summary.at("rocks").as_integer(), 2);
  EXPECT_EQ(summary.at("rejected_by_reason").at("not_above_ground").as_integer(), 1);
  EXPECT_EQ(summary.at("rejected_by_reason").at("cloud_missing").as_integer(), 1);
  EXPECT_EQ(summary.at("segments").size(), 4U);
  EXPECT_THAT(result.err, HasSubstr("no CRS is declared"));

  const auto before = ::cairn::io::read_cloud(cloud_), after = ::cairn::io::read_cloud(out_);
  ASSERT_EQ(after.cloud.size(), before.cloud.size());
  EXPECT_EQ(after.cloud.positions[77], before.cloud.positions[77]);
  ASSERT_NE(after.cloud.scalar("label"), nullptr);
  EXPECT_EQ(after.cloud.scalar("label")->type, ::cairn::geometry::ScalarType::u8);
  EXPECT_EQ(after.cloud.scalar("target_id")->type, ::cairn::geometry::ScalarType::u32);
  std::size_t rock2 = 0;
  for (std::size_t i = 0; i < after.cloud.size(); ++i)
    if (after.cloud.scalar("target_id")->values[i] == 2.0) {
      EXPECT_EQ(after.cloud.scalar("label")->values[i], 2.0);
      ++rock2;
    }
  EXPECT_GT(rock2, 10500U);
  EXPECT_TRUE(fs::exists(out_ + ".run.json"));
}

TEST_F(SegmentCommand, SameBytesForAnyNumberOfThreads) {
  const auto bytes = [&](const char* threads) {
    const auto result =
        cairn({"segment", cloud_, "--targets", targets_, "-o", out_, "--threads", threads, "--overwrite"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return ::cairn::base::read_file(out_);
  };
  EXPECT_EQ(bytes("1"), bytes("4"));
}

TEST_F(SegmentCommand, BadInput) {
  EXPECT_EQ(cairn({"segment", cloud_, "-o", out_}).exit_code, 2);
  EXPECT_EQ(cairn({"segment", (folder_ / "none.las").string(), "--targets", targets_, "-o", out_}).exit_code, 4);
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", cloud_, "-o", out_}).exit_code, 4);
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", targets_, "-o", out_, "--noise-factor", "-1"}).exit_code, 2);
  EXPECT_FALSE(fs::exists(out_));
  ASSERT_EQ(cairn({"segment", cloud_, "--targets", targets_, "-o", out_}).exit_code, 0);
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", targets_, "-o", out_}).exit_code, 7);
}

}  // namespace
