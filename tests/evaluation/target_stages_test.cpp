#include "evaluation/target_stages.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cairn::evaluation {
namespace {

using survey::DetectionId;
using survey::FrameId;
using survey::ObjectId;
using survey::TargetId;
using survey::TargetState;
using ::testing::ElementsAre;

constexpr std::size_t kGenerated = 0, kConverging = 1, kConverged = 2, kMapped = 3;

// Objects 1 and 2 are sought, 9 is not. Frames 0..9, a tenth of a second apart; each shows 1 and 2 whole.
class Stages : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const int id : {1, 2, 9}) {
      survey::TruthObject object;
      object.id = ObjectId(id);
      object.sought = id != 9;
      truth_.objects.push_back(object);
    }
    for (int f = 0; f < 10; ++f) {
      survey::Frame frame;
      frame.id = FrameId(f);
      frame.time_ns = f * 100'000'000LL;
      truth_.frames.push_back(frame);
      for (const int id : {1, 2}) truth_.boxes.push_back({FrameId(f), ObjectId(id), {0, 0, 9, 9}, true, 1.0});
    }
  }
  // A box in a frame; object 0 = a false one.
  DetectionId box(int frame, int object) {
    survey::Detection d;
    d.id = DetectionId(static_cast<std::int64_t>(detections_.size()));
    d.frame = FrameId(frame);
    detections_.push_back(d);
    truth_.detections.push_back({d.id, object == 0 ? ObjectId() : ObjectId(object), -1});
    return d.id;
  }
  void target(int id, std::vector<DetectionId> boxes, std::vector<survey::StageEntry> history,
              TargetState state = TargetState::converged) {
    survey::Target t;
    t.id = TargetId(id);
    t.detections = std::move(boxes);
    t.history = std::move(history);
    t.state = state;
    targets_.push_back(t);
  }
  [[nodiscard]] StageScores score(StageOptions options = {}) const {
    return score_stages(targets_, detections_, truth_, options);
  }

  survey::Truth truth_;
  std::vector<survey::Detection> detections_;
  std::vector<survey::Target> targets_;
};

TEST_F(Stages, MostOfTheBoxesSoFarDecide) {
  // At frame 1 two of three boxes are false; by frame 4 three of five are of object 1.
  target(1, {box(0, 0), box(1, 0), box(1, 1), box(3, 1), box(4, 1)},
         {{TargetState::generated, FrameId(1)}, {TargetState::converging, FrameId(4)}});
  const auto s = score();
  EXPECT_EQ(s.stages[kGenerated].tp, 0U);
  EXPECT_EQ(s.stages[kGenerated].fp, 1U);
  EXPECT_EQ(s.stages[kGenerated].entries[0].verdict, Verdict::no_object);
  EXPECT_EQ(s.stages[kConverging].tp, 1U);
  EXPECT_EQ(s.stages[kConverging].fp, 0U);
  EXPECT_THAT(s.object_of, ElementsAre(ObjectId(1)));
}

TEST_F(Stages, HalfIsNotMost) {
  target(1, {box(0, 1), box(0, 2)}, {{TargetState::generated, FrameId(0)}});
  const auto s = score();
  EXPECT_EQ(s.stages[kGenerated].entries[0].verdict, Verdict::no_majority);
  EXPECT_EQ(s.stages[kGenerated].fp, 1U);
}

TEST_F(Stages, TheSecondOfOneObjectIsFalseWhicheverIsListedFirst) {
  target(1, {box(5, 1)}, {{TargetState::generated, FrameId(5)}});
  target(2, {box(2, 1)}, {{TargetState::generated, FrameId(2)}});
  const auto s = score();
  const auto& g = s.stages[kGenerated];
  ASSERT_EQ(g.entries.size(), 2U);
  EXPECT_EQ(g.entries[0].target, TargetId(2));
  EXPECT_EQ(g.entries[0].verdict, Verdict::right);
  EXPECT_EQ(g.entries[1].verdict, Verdict::duplicate);
  EXPECT_EQ(g.tp, 1U);
  EXPECT_EQ(g.fp, 1U);
  EXPECT_DOUBLE_EQ(*g.precision(), 0.5);
}

// A duplicate that died while generated does not make the next stage's first entry a duplicate.
TEST_F(Stages, DuplicatesAreJudgedStageByStage) {
  target(1, {box(0, 1)}, {{TargetState::generated, FrameId(0)}}, TargetState::deregistered);
  target(2, {box(2, 1), box(3, 1)}, {{TargetState::generated, FrameId(2)}, {TargetState::converging, FrameId(3)}});
  const auto s = score();
  EXPECT_EQ(s.stages[kGenerated].fp, 1U);
  EXPECT_EQ(s.stages[kConverging].tp, 1U);
  EXPECT_EQ(s.stages[kConverging].fp, 0U);
}

TEST_F(Stages, DistractorsAreFalse) {
  target(1, {box(0, 9)}, {{TargetState::generated, FrameId(0)}});
  const auto s = score();
  EXPECT_EQ(s.stages[kGenerated].entries[0].verdict, Verdict::distractor);
  EXPECT_EQ(s.stages[kGenerated].entries[0].object, ObjectId(9));
}

TEST_F(Stages, TargetsOfOtherClassesAreNotScored) {
  for (auto& object : truth_.objects) object.object_class = object.sought ? "pbr" : "boulder";
  target(1, {box(0, 9)}, {{TargetState::generated, FrameId(0)}});
  targets_.back().object_class = "boulder";
  target(2, {box(0, 9)}, {{TargetState::generated, FrameId(0)}});
  targets_.back().object_class = "pbr";
  const auto s = score();
  EXPECT_EQ(s.other_classes, 1U);
  EXPECT_EQ(s.stages[kGenerated].entries.size(), 1U);
  EXPECT_EQ(s.stages[kGenerated].fp, 1U);
  EXPECT_EQ(s.object_of.size(), 2U);
}

TEST_F(Stages, TimeOrdersFramesNotTheirIds) {
  // Frame 7 was taken first: at the entry in frame 7, the box of frame 3 is still to come.
  truth_.frames[7].time_ns = -1'000'000'000;
  target(1, {box(3, 0), box(4, 0), box(7, 1)}, {{TargetState::generated, FrameId(7)}});
  EXPECT_EQ(score().stages[kGenerated].tp, 1U);
}

TEST_F(Stages, MissedIsWhatWasSeenWholeInEnoughFrames) {
  target(1, {box(0, 1)}, {{TargetState::generated, FrameId(0)}}, TargetState::generated);
  auto s = score();
  EXPECT_EQ(s.seen_whole, 10U);  // 0.1 s between frames: video
  EXPECT_THAT(s.sought, ElementsAre(ObjectId(1), ObjectId(2)));
  EXPECT_THAT(s.stages[kGenerated].missed, ElementsAre(ObjectId(2)));
  EXPECT_DOUBLE_EQ(*s.stages[kGenerated].recall(), 0.5);
  EXPECT_EQ(s.stages[kConverging].fn, 2U);
  EXPECT_DOUBLE_EQ(*s.stages[kConverging].recall(), 0.0);
  EXPECT_FALSE(s.stages[kConverging].precision().has_value());

  truth_.boxes.back().whole = false;  // object 2 in nine frames only
  s = score();
  EXPECT_EQ(s.stages[kGenerated].fn, 0U);
  EXPECT_EQ(score({.seen_whole = 9}).stages[kGenerated].fn, 1U);
  truth_.boxes[truth_.boxes.size() - 3].visible_share = 0.4;
  EXPECT_EQ(score({.seen_whole = 9}).stages[kGenerated].fn, 0U);
  EXPECT_EQ(score({.seen_whole = 9, .min_visible_share = 0.3}).stages[kGenerated].fn, 1U);

  for (auto& frame : truth_.frames) frame.time_ns *= 100;  // ten seconds apart: photos
  EXPECT_EQ(score().seen_whole, 3U);
}

TEST_F(Stages, WithoutHistoryTheFinalStateSpeaks) {
  target(1, {box(0, 1), box(1, 1)}, {}, TargetState::converged);
  target(2, {box(0, 2)}, {}, TargetState::deregistered);
  const auto s = score();
  EXPECT_EQ(s.without_history, 2U);
  EXPECT_EQ(s.stages[kGenerated].tp, 2U);
  EXPECT_EQ(s.stages[kConverging].tp, 1U);
  EXPECT_EQ(s.stages[kConverged].tp, 1U);
  EXPECT_EQ(s.stages[kMapped].tp + s.stages[kMapped].fp, 0U);
}

TEST_F(Stages, TargetsWithoutBoxesAndUnknownRecords) {
  target(1, {}, {{TargetState::generated, FrameId(0)}});
  target(2, {DetectionId(999)}, {{TargetState::generated, FrameId(777)}});
  const auto stray = box(55, 1);  // a frame that truth does not know: at no moment before a known frame
  target(3, {stray}, {{TargetState::generated, FrameId(0)}});
  const auto s = score();
  for (const auto& entry : s.stages[kGenerated].entries) EXPECT_EQ(entry.verdict, Verdict::without_boxes);
  EXPECT_EQ(s.stages[kGenerated].fp, 3U);
}

// Paper A's own counts (Table I) as a scene: 11 of 13, 8 of 9, 7 of 8 found.
TEST_F(Stages, TableOneOfThePaper) {
  truth_.objects.clear();
  truth_.boxes.clear();
  for (int id = 1; id <= 8; ++id) {
    survey::TruthObject object;
    object.id = ObjectId(id);
    object.sought = true;
    truth_.objects.push_back(object);
    for (int f = 0; f < 10; ++f) truth_.boxes.push_back({FrameId(f), ObjectId(id), {0, 0, 9, 9}, true, 1.0});
  }
  // Eight true targets, seven of which converge; one false target converging; three more false ones generated.
  for (int id = 1; id <= 8; ++id) {
    std::vector<survey::StageEntry> history{{TargetState::generated, FrameId(0)},
                                            {TargetState::converging, FrameId(1)}};
    if (id < 8) history.push_back({TargetState::converged, FrameId(2)});
    target(id, {box(0, id), box(1, id), box(2, id)}, history);
  }
  target(20, {box(0, 0), box(1, 0)}, {{TargetState::generated, FrameId(0)}, {TargetState::converging, FrameId(1)}});
  target(21, {box(0, 0)}, {{TargetState::generated, FrameId(0)}});
  const auto s = score();
  EXPECT_NEAR(*s.stages[kConverging].precision(), 0.889, 5e-4);
  EXPECT_DOUBLE_EQ(*s.stages[kConverging].recall(), 1.0);
  EXPECT_DOUBLE_EQ(*s.stages[kConverged].precision(), 1.0);
  EXPECT_NEAR(*s.stages[kConverged].recall(), 0.875, 5e-4);
}

}  // namespace
}  // namespace cairn::evaluation
