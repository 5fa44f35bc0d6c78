#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "base/atomic_file.hpp"
#include "io/cloud.hpp"
#include "io/json.hpp"
#include "io/rocks_json.hpp"
#include "io/targets_json.hpp"
#include "pipeline/review_record.hpp"
#include "support/data.hpp"
#include "support/rock_result.hpp"
#include "support/run_program.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::testing::cairn;
using cairn::testing::ProgramResult;
using cairn::testing::TempFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kHeader = "rock_id,action,value,reason,operator,time\n";
constexpr double kPostVolume_m3 = 3.14159265 * 0.3 * 0.3 * 1.0;
// Meshes through scattered points cut the corners of a 0.3 m post.
constexpr double kMeshTolerance = 0.08;

class ReviewCommand : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    site_ = new TempFolder;
    ::cairn::testing::write_rock_result(site_->path());
  }
  static void TearDownTestSuite() {
    delete site_;
    site_ = nullptr;
  }
  [[nodiscard]] static fs::path result() { return site_->path() / "result"; }

  [[nodiscard]] ProgramResult review(const std::string& rows, const std::string& out = "out",
                                     const fs::path& of = result()) const {
    ::cairn::base::write_file(folder_ / "edits.csv", kHeader + rows);
    return cairn(
        {"review", of.string(), "--edits", (folder_ / "edits.csv").string(), "-o", (folder_ / out).string(), "--json"});
  }
  [[nodiscard]] std::map<std::int64_t, ::cairn::survey::Rock> rocks(const fs::path& of) const {
    std::map<std::int64_t, ::cairn::survey::Rock> by_id;
    for (auto& rock : ::cairn::io::read_rocks(of / "rocks.json").rocks) by_id.emplace(rock.target.value, rock);
    return by_id;
  }
  static std::string bytes(const fs::path& file) { return ::cairn::base::read_file(file); }
  // The files of rocks/ that belong to a rock are those of the result.
  void expect_same_files(std::int64_t id, const fs::path& of) const {
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(result() / "rocks")) {
      const std::string name = entry.path().filename().string();
      if (name.rfind(std::to_string(id) + ".", 0) != 0 && name.rfind(std::to_string(id) + "_", 0) != 0) continue;
      ++files;
      EXPECT_EQ(bytes(entry.path()), bytes(of / "rocks" / name)) << name;
    }
    EXPECT_GE(files, 3U);
  }

  static TempFolder* site_;
  TempFolder folder_;
};
TempFolder* ReviewCommand::site_ = nullptr;

TEST_F(ReviewCommand, DecisionsTakePrecedenceAndComputeNothing) {
  const auto run = review(
      "1,reject,,\"a bush, not a rock\",ada,2026-05-01T10:00:00Z\n"
      "5,accept,,seen in the field,ada,2026-05-01T10:01:00Z\n"
      "4,reclassify,precarious,,ada,2026-05-01T10:02:00Z\n"
      "two-posts-0004,set,name=The Twins,,bob,2026-05-01T10:03:00Z\n"
      "4,note,lichen on the south side,,bob,2026-05-01T10:03:00Z\n");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ::cairn::io::parse_json(run.out, "stdout");
  EXPECT_EQ(summary.at("computed_again").size(), 0U);
  const auto now = rocks(folder_ / "out");
  EXPECT_TRUE(now.at(1).rejected);
  EXPECT_THAT(now.at(1).reasons, ElementsAre("rejected_in_review"));
  EXPECT_TRUE(now.at(1).mass.has_value());  // the figures stay, so that it can be accepted again
  EXPECT_FALSE(now.at(5).rejected);
  EXPECT_EQ(now.at(5).review, "accept");
  EXPECT_EQ(now.at(4).name, "The Twins");
  const auto record = ::cairn::pipeline::read_review(folder_ / "out" / "review.json");
  EXPECT_EQ(record.edits.size(), 5U);
  EXPECT_EQ(record.rocks.at(4).judgement, "precarious");
  EXPECT_EQ(record.rocks.at(4).reviewer, "bob");
  EXPECT_THAT(record.rocks.at(4).notes, ElementsAre("lichen on the south side"));
  for (const std::int64_t id : {1, 2, 3, 4}) expect_same_files(id, folder_ / "out");
  for (const char* name : {"labelled.las", "segments.json", "targets.json"})
    EXPECT_EQ(bytes(result() / name), bytes(folder_ / "out" / name)) << name;
}

TEST_F(ReviewCommand, MergeAndSplitComputeOnlyWhatTheyTouch) {
  const auto run = review(
      "2,merge,3,one post,ada,2026-05-01T10:00:00Z\n"
      "4,split,\"8,0;9.2,0\",two posts,ada,2026-05-01T10:01:00Z\n");
  ASSERT_EQ(run.exit_code, 0) << run.err << run.out;
  const auto summary = ::cairn::io::parse_json(run.out, "stdout");
  EXPECT_EQ(summary.at("computed_again").dump(0), "[2,4,6]");
  const auto before = rocks(result()), now = rocks(folder_ / "out");
  EXPECT_EQ(now.size(), 5U);  // 1, 2, 4, 5, 6
  EXPECT_FALSE(now.contains(3));
  EXPECT_THAT(now.at(2).aliases, ElementsAre(::cairn::survey::TargetId(3)));
  EXPECT_THAT(now.at(2).supersedes, ElementsAre(::cairn::survey::TargetId(3)));
  EXPECT_THAT(now.at(6).supersedes, ElementsAre(::cairn::survey::TargetId(4)));
  for (const std::int64_t id : {2, 4, 6}) {
    ASSERT_TRUE(now.at(id).mass) << id;
    EXPECT_NEAR(now.at(id).mass->volume, kPostVolume_m3, kMeshTolerance * kPostVolume_m3) << id;
    EXPECT_EQ(now.at(id).point_count, 2500U);
  }
  EXPECT_LT(before.at(2).mass->volume, 0.8 * now.at(2).mass->volume);  // half of the post, closed on top by the surface
  // What no decision touches is the same to the byte, in its files and in its record.
  expect_same_files(1, folder_ / "out");
  EXPECT_EQ(::cairn::io::to_json(before.at(1)).dump(), ::cairn::io::to_json(now.at(1)).dump());
  for (const auto& entry : fs::directory_iterator(folder_ / "out" / "rocks"))
    EXPECT_NE(entry.path().filename().string().front(), '3') << entry.path();
  EXPECT_FALSE(fs::exists(folder_ / "out" / ".review"));
  const auto cloud = ::cairn::io::read_cloud(folder_ / "out" / "labelled.las").cloud;
  std::map<double, int> owners;
  for (const double id : cloud.scalar("target_id")->values) ++owners[id];
  EXPECT_EQ(owners[2], 2500);
  EXPECT_EQ(owners[3], 0);
  EXPECT_EQ(owners[6], 2500);
  for (const auto& target : ::cairn::io::read_targets(folder_ / "out" / "targets.json").targets)
    if (target.id.value == 3) {
      EXPECT_EQ(target.state, ::cairn::survey::TargetState::deregistered);
      EXPECT_THAT(target.reasons, ElementsAre("merged_in_review"));
    }

  // Decisions may name the merged rock by its old id; a review of a review carries on.
  const std::string first =
      "2,merge,3,one post,ada,2026-05-01T10:00:00Z\n"
      "4,split,\"8,0;9.2,0\",two posts,ada,2026-05-01T10:01:00Z\n";
  const auto next = review(first + "3,set,density=2700,weighed,bob,2026-05-02T09:00:00Z\n", "next", folder_ / "out");
  ASSERT_EQ(next.exit_code, 0) << next.err;
  EXPECT_EQ(::cairn::io::parse_json(next.out, "stdout").at("computed_again").dump(0), "[2]");
  const auto denser = rocks(folder_ / "next");
  EXPECT_EQ(denser.at(2).density_kg_m3, 2700.0);
  EXPECT_FALSE(denser.at(2).density_assumed);
  ASSERT_EQ(denser.at(2).tipping.critical.has_value(), now.at(2).tipping.critical.has_value());
  EXPECT_EQ(bytes(folder_ / "out" / "rocks" / "2.ply"), bytes(folder_ / "next" / "rocks" / "2.ply"));
  EXPECT_EQ(::cairn::io::to_json(denser.at(6)).dump(), ::cairn::io::to_json(now.at(6)).dump());

  // All at once gives the same rocks.
  const auto once = review(first + "3,set,density=2700,weighed,bob,2026-05-02T09:00:00Z\n", "once");
  ASSERT_EQ(once.exit_code, 0) << once.err;
  EXPECT_EQ(bytes(folder_ / "once" / "rocks.json"), bytes(folder_ / "next" / "rocks.json"));
  EXPECT_EQ(bytes(folder_ / "once" / "review.json"), bytes(folder_ / "next" / "review.json"));

  // Rows that were applied cannot be changed afterwards.
  const auto tampered = review("2,merge,3,one post,ada,2026-05-01T10:00:00Z\n", "tampered", folder_ / "out");
  EXPECT_EQ(tampered.exit_code, 4);
  EXPECT_THAT(tampered.err, HasSubstr("append-only"));
}

TEST_F(ReviewCommand, BadDecisionsNameTheLineAndTheRemedy) {
  const std::string t = ",ada,2026-05-01T10:00:00Z\n";
  const std::vector<std::tuple<std::string, std::string, std::string>> cases{
      {"99,accept,," + t, "no rock of the result has this id", "1, 2, 3, 4, 5"},
      {"elsewhere-0001,accept,," + t, "another survey", "two-posts-"},
      {"1,delete,," + t, "unknown action", "accept, reject, merge, split"},
      {"1,merge,5," + t, "rock 5 was rejected by the automatic result: too_few_points", "accept for it first"},
      {"3,reject,," + t + "2,merge,3," + t, "rock 3 was rejected by line 2 of edits.csv", "line 3"},
      {"2,merge,2," + t, "merged with itself", "line 2"},
      {"2,merge,," + t, "needs a value", "7;12"},
      {"2,merge,3," + t + "2,merge,3," + t, "merged with itself", "which is rock 2"},
      {"4,split,\"8,0\"," + t, "seed for each part", "two or more"},
      {"4,split,\"8,0;x,1\"," + t, "cannot be read", "east,north"},
      {"4,split,\"8,0;90,0\"," + t, "seed 2 of the split gets no point", "line 2"},
      {"5,split,\"8,0;9,0\"," + t, "cannot be split", "accept for it first"},
      {"1,set,colour=red," + t, "no such field", "lithology"},
      {"1,set,density=heavy," + t, "does not fit", "a number [kg/m3]"},
      {"1,set,density=12," + t, "does not fit", "500 to 8000"},
      {"1,reclassify,Big Rock," + t, "not a class", "small letters"},
      {"1,accept,,,ada,2026-05-01T10:00:00Z\n2,accept,,,ada,2026-05-01T09:59:59Z\n", "earlier than the decision before",
       "line 3"},
      {"1,accept,,,ada,yesterday\n", "not a time", "2026-05-01T10:20:30Z"},
      {"1,accept,,,,2026-05-01T10:00:00Z\n", "operator", "line 2"},
  };
  for (const auto& [rows, message, detail] : cases) {
    const auto run = review(rows);
    EXPECT_EQ(run.exit_code, 4) << rows << run.err;
    EXPECT_THAT(run.err, HasSubstr(message)) << rows;
    EXPECT_THAT(run.err, HasSubstr(detail)) << rows;
    EXPECT_FALSE(fs::exists(folder_ / "out")) << rows;
  }
  const auto no_edits = cairn({"review", result().string(), "-o", (folder_ / "out").string()});
  EXPECT_EQ(no_edits.exit_code, 2);
  const auto nowhere = review("", "out", folder_ / "nothing");
  EXPECT_EQ(nowhere.exit_code, 4);
  EXPECT_THAT(nowhere.err, HasSubstr("no rocks"));
}

}  // namespace
