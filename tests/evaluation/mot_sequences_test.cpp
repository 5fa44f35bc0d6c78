// Published sequences with truth: the scores of the reference tracker's results equal those that its authors print.
// The folder of the sequences (each with gt.txt and sort_reference.txt) is named by the environment variable
// CAIRN_MOT_DATA: their terms forbid a copy here.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "pipeline/evaluate_stage.hpp"

namespace {

namespace fs = std::filesystem;
using cairn::io::Json;

constexpr double kPrinted = 5e-4;  // the authors print per cent with one decimal
constexpr double kOracle = 1e-9;   // the same definitions computed with numpy and scipy

Json score(const fs::path& sequence) {
  cairn::base::RunContext ctx;
  return cairn::pipeline::evaluate_tracks({.result = sequence / "sort_reference.txt", .truth = sequence / "gt.txt"}, {},
                                          ctx)
      .summary;
}

class MotScores : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("CAIRN_MOT_DATA");
    if (folder == nullptr || !fs::exists(fs::path(folder) / "TUD-Campus/gt.txt"))
      GTEST_SKIP() << "CAIRN_MOT_DATA does not name a folder with TUD-Campus/gt.txt";
    folder_ = folder;
  }
  fs::path folder_;
};

// github.com/abewley/sort, README: Rcll 68.5, Prcn 94.3, GT 8, MT 6, ML 0, FP 15, FN 113, IDs 6, FM 9, MOTA 62.7,
// MOTP 73.7.
TEST_F(MotScores, TudCampusAsPublished) {
  const Json s = score(folder_ / "TUD-Campus");
  EXPECT_EQ(s.at("objects").as_integer(), 8);
  EXPECT_EQ(s.at("mostly_tracked").as_integer(), 6);
  EXPECT_EQ(s.at("mostly_lost").as_integer(), 0);
  EXPECT_EQ(s.at("fp").as_integer(), 15);
  EXPECT_EQ(s.at("fn").as_integer(), 113);
  EXPECT_EQ(s.at("id_switches").as_integer(), 6);
  EXPECT_EQ(s.at("fragmentations").as_integer(), 9);
  EXPECT_NEAR(s.at("recall").as_real(), 0.685, kPrinted);
  EXPECT_NEAR(s.at("precision").as_real(), 0.943, kPrinted);
  EXPECT_NEAR(s.at("mota").as_real(), 0.627, kPrinted);
  EXPECT_NEAR(s.at("motp").as_real(), 0.737, kPrinted);
  EXPECT_NEAR(s.at("idf1").as_real(), 2.0 * 188.0 / 620.0, kOracle);
  EXPECT_NEAR(s.at("hota").as_real(), 0.4525695174932174, kOracle);
  EXPECT_NEAR(s.at("det_a").as_real(), 0.488254663810578, kOracle);
  EXPECT_NEAR(s.at("ass_a").as_real(), 0.42281839701083174, kOracle);
  EXPECT_NEAR(s.at("loc_a").as_real(), 0.7793454062521904, kOracle);
}

TEST_F(MotScores, TudStadtmitteAsTheOracle) {
  const Json s = score(folder_ / "TUD-Stadtmitte");
  EXPECT_EQ(s.at("fp").as_integer(), 22);
  EXPECT_EQ(s.at("fn").as_integer(), 295);
  EXPECT_EQ(s.at("id_switches").as_integer(), 10);
  EXPECT_EQ(s.at("idtp").as_integer(), 749);
  EXPECT_NEAR(s.at("mota").as_real(), 0.717128027681661, kOracle);
  EXPECT_NEAR(s.at("motp").as_real(), 0.7523497227151557, kOracle);
  EXPECT_NEAR(s.at("hota").as_real(), 0.530335161332517, kOracle);
  EXPECT_NEAR(s.at("ass_a").as_real(), 0.5127581405136425, kOracle);
}

}  // namespace
