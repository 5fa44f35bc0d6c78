#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "base/atomic_file.hpp"
#include "io/cloud.hpp"
#include "io/contact_csv.hpp"
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
      EXPECT_GE(after.cloud.scalar("label")->values[i], 2.0);
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
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", targets_, "--picks", targets_, "-o", out_}).exit_code, 4);
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", targets_, "--contact", targets_, "-o", out_}).exit_code, 4);
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", targets_, "-o", out_, "--method", "guess"}).exit_code, 2);
  EXPECT_EQ(cairn({"segment", (folder_ / "none.las").string(), "--targets", targets_, "-o", out_}).exit_code, 4);
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", cloud_, "-o", out_}).exit_code, 4);
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", targets_, "-o", out_, "--noise-factor", "-1"}).exit_code, 2);
  EXPECT_FALSE(fs::exists(out_));
  ASSERT_EQ(cairn({"segment", cloud_, "--targets", targets_, "-o", out_}).exit_code, 0);
  EXPECT_EQ(cairn({"segment", cloud_, "--targets", targets_, "-o", out_}).exit_code, 7);
}

TEST_F(SegmentCommand, FindsRocksWithoutTargets) {
  const auto result = cairn({"segment", cloud_, "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto summary = ::cairn::io::parse_json(result.out, "stdout");
  EXPECT_FALSE(summary.at("guided").as_bool());
  EXPECT_EQ(summary.at("rocks").as_integer(), 2);
}

TEST_F(SegmentCommand, WritesContactsAndTheOtherConvention) {
  namespace io = ::cairn::io;
  const auto result =
      cairn({"segment", cloud_, "--targets", targets_, "-o", out_, "--intensity-labels", "--method", "crease"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto beside = folder_ / "labelled.contact.csv";
  ASSERT_TRUE(fs::exists(beside));
  EXPECT_EQ(io::read_contact_csv(beside).crs, "local");
  const auto after = io::read_cloud(out_);
  ASSERT_NE(after.cloud.scalar("probability"), nullptr);
  EXPECT_EQ(after.cloud.scalar("probability")->type, ::cairn::geometry::ScalarType::f32);
  ASSERT_EQ(after.cloud.intensity.size(), after.cloud.size());
  for (std::size_t i = 0; i < after.cloud.size(); ++i) {
    const double label = after.cloud.scalar("label")->values[i];
    EXPECT_EQ(after.cloud.intensity[i], label == 2.0 ? 1 : label == 4.0 ? 2 : 0);
    EXPECT_GE(after.cloud.scalar("probability")->values[i], 0.0);
    EXPECT_LE(after.cloud.scalar("probability")->values[i], 1.0);
  }
}

TEST_F(SegmentCommand, ADigitisedContactIsTakenAsItStands) {
  namespace io = ::cairn::io;
  io::ContactFile given;
  given.crs = "local";
  for (int k = 0; k < 40; ++k) {
    const double a = 6.283185307179586 * k / 40;
    given.rows.push_back({2, {0, k, {3 + 0.5 * std::cos(a), 0.5 * std::sin(a), 20.0}, true, true, 0.01}});
  }
  const auto path = folder_ / "given.csv";
  io::write_contact_csv(path, given);
  const auto result =
      cairn({"segment", cloud_, "--targets", targets_, "--contact", path.string(), "-o", out_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto written = io::read_contact_csv(folder_ / "labelled.contact.csv");
  std::size_t same = 0;
  for (const auto& row : written.rows)
    if (row.rock_id == 2 &&
        (row.vertex.position - given.rows[static_cast<std::size_t>(row.vertex.order)].vertex.position).norm() < 1e-9)
      ++same;
  EXPECT_EQ(same, 40U);
}

}  // namespace
