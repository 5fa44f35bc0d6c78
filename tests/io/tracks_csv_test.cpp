#include "io/tracks_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "support/data.hpp"
#include "support/nadir_survey.hpp"

namespace {

using namespace cairn;
using cairn::testing::TempFolder;
using ::testing::HasSubstr;

constexpr const char* kHeader = "detection_id,frame_id,class,score,xmin_px,ymin_px,xmax_px,ymax_px,track_id,state\n";

class TracksCsv : public ::testing::Test {
 protected:
  TempFolder folder_;
  cairn::testing::NadirSurvey made_{3};
  void SetUp() override { made_.object({8, 0, 0}); }

  std::string refusal(const std::string& rows) const {
    base::write_file(folder_ / "tracks.csv", kHeader + rows);
    try {
      static_cast<void>(io::read_tracks(folder_ / "tracks.csv", made_.survey));
    } catch (const base::Error& e) {
      return e.what();
    }
    return "accepted";
  }
};

TEST_F(TracksCsv, RoundTrip) {
  std::vector<survey::TrackedBox> rows;
  for (const auto& d : made_.survey.detections) rows.push_back({survey::TrackId(4), survey::TrackState::detected, d});
  survey::TrackedBox coasted = rows.back();
  coasted.track = survey::TrackId(9);
  coasted.state = survey::TrackState::coasted;
  coasted.box.id = {};
  coasted.box.box.xmin = 0.1;
  rows.push_back(coasted);
  ASSERT_GE(rows.size(), 3U);
  io::write_tracks(folder_ / "tracks.csv", rows);
  EXPECT_EQ(io::read_tracks(folder_ / "tracks.csv", made_.survey), rows);
}

TEST_F(TracksCsv, ComesBackByFrameAndTrack) {
  EXPECT_EQ(refusal(",2,rock,1,0,0,5,5,1,coasted\n,1,rock,1,0,0,5,5,3,coasted\n,1,rock,1,0,0,5,5,2,coasted\n"),
            "accepted");
  const auto rows = io::read_tracks(folder_ / "tracks.csv", made_.survey);
  EXPECT_EQ(rows[0].track.value, 2);
  EXPECT_EQ(rows[2].box.frame.value, 2);
}

TEST_F(TracksCsv, Refusals) {
  EXPECT_THAT(refusal(",1,rock,1,0,0,5,5,1,detected\n"), HasSubstr("line 2, column detection_id"));
  EXPECT_THAT(refusal("999,1,rock,1,0,0,5,5,1,detected\n"), HasSubstr("unknown detection"));
  EXPECT_THAT(refusal(",99,rock,1,0,0,5,5,1,coasted\n"), HasSubstr("unknown frame"));
  EXPECT_THAT(refusal(",1,rock,1,0,0,5,5,1,lost\n"), HasSubstr("detected, coasted"));
  EXPECT_THAT(refusal(",1,rock,1,6,0,5,5,1,coasted\n"), HasSubstr("ends before it begins"));
  EXPECT_THAT(refusal(",1,rock,nan,0,0,5,5,1,coasted\n"), HasSubstr("score"));
  EXPECT_THAT(refusal(",1,rock,1,0,0,5,5,1,coasted\n,1,rock,1,0,0,5,5,1,coasted\n"),
              HasSubstr("two boxes in one frame"));
}

TEST_F(TracksCsv, WritesNothingThatIsNotFinite) {
  survey::TrackedBox row;
  row.track = survey::TrackId(1);
  row.box.frame = survey::FrameId(1);
  row.box.box = {0, 0, std::numeric_limits<double>::quiet_NaN(), 1};
  EXPECT_THROW(io::write_tracks(folder_ / "bad.csv", std::span(&row, 1)), base::Error);
}

}  // namespace
