#include "adjustment/evidence_pairs.hpp"

#include <gmock/gmock.h>

#include "support/simulated_survey.hpp"

namespace cairn::adjustment {
namespace {

using geometry::RigidTransform;
using geometry::Vec2;
using geometry::Vec3;
using survey::FrameId;
using survey::Survey;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Matches of neighbouring frames through the tie points both see, as a feature matcher would give them.
std::vector<MatchedPair> matches_of(const Survey& survey) {
  std::vector<MatchedPair> result;
  for (const auto& [a, b] : neighbour_pairs(survey)) {
    MatchedPair pair{survey.frames[a].id, survey.frames[b].id, {}};
    for (const auto& tie : survey.ties) {
      const survey::TieObservation *seen_a = nullptr, *seen_b = nullptr;
      for (const auto& observation : tie.observations) {
        if (observation.frame == pair.a) seen_a = &observation;
        if (observation.frame == pair.b) seen_b = &observation;
      }
      if (seen_a != nullptr && seen_b != nullptr) pair.matches.push_back({seen_a->pixel, seen_b->pixel});
    }
    result.push_back(std::move(pair));
  }
  return result;
}

// The poses an aircraft reports: positions to a metre, attitudes to two degrees.
void add_pose_noise(Survey& survey, std::uint64_t seed) {
  base::Random random(seed, "pose noise", 0);
  for (auto& frame : survey.frames) {
    auto& T = frame.T_world_camera;
    T.translation += Vec3(random.normal(), random.normal(), 0.3 * random.normal());
    const Vec3 axis = Vec3(random.normal(), random.normal(), random.normal()).normalized();
    T.rotation = geometry::axis_rotation(axis, base::deg_to_rad(2.0 * random.normal())) * T.rotation;
  }
}

void turn(Survey& survey, std::int64_t first, std::int64_t last) {
  const auto& camera = survey.manifest.cameras.front();
  const Vec2 far(static_cast<double>(camera.width_px), static_cast<double>(camera.height_px));
  for (auto& tie : survey.ties)
    for (auto& observation : tie.observations)
      if (observation.frame.value >= first && observation.frame.value <= last)
        observation.pixel = far - observation.pixel;
}

TEST(PairEvidence, SoundSurveyHasNoVerdict) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    auto survey = testing::simulated_survey();
    const auto matched = matches_of(survey);
    add_pose_noise(survey, seed);
    const auto evidence = pair_evidence(survey, matched);
    EXPECT_THAT(evidence.verdicts, IsEmpty());
    EXPECT_THAT(evidence.unexplained, IsEmpty());
    EXPECT_THAT(evidence.unmatched, IsEmpty());
    EXPECT_THAT(evidence.pairs, SizeIs(matched.size()));
  }
}

TEST(PairEvidence, GroundPlaneOfASoundPairIsTheGround) {
  const auto survey = testing::simulated_survey();
  for (const auto& pair : pair_evidence(survey, matches_of(survey)).pairs) {
    constexpr double kReliefM = 1.3;  // amplitude of the bumps
    EXPECT_NEAR(pair.plane_up_m, 3.0, kReliefM);
    EXPECT_LT(pair.declared_m, kReliefM);
    EXPECT_NEAR(pair.turn_deg, 0.0, 3.0);  // relief and noise turn a similarity by less than this [deg]
  }
}

TEST(PairEvidence, BlamesTheTurnedFramesAndNoOthers) {
  struct Case {
    std::int64_t first, last;
  };
  // One frame, a whole leg, and the majority: which set is turned is decided by the positions, not by counting.
  for (const auto& [first, last] : {Case{6, 6}, Case{5, 8}, Case{5, 12}, Case{1, 12}})
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      auto survey = testing::simulated_survey();
      turn(survey, first, last);
      const auto matched = matches_of(survey);
      add_pose_noise(survey, seed);
      const auto evidence = pair_evidence(survey, matched);
      ASSERT_THAT(evidence.verdicts, SizeIs(1)) << first << " to " << last;
      EXPECT_EQ(evidence.verdicts[0].code, "frame_turned_180");
      std::vector<FrameId> expected;
      for (std::int64_t id = first; id <= last; ++id) expected.emplace_back(id);
      EXPECT_EQ(evidence.verdicts[0].frames, expected);
      EXPECT_LT(evidence.verdicts[0].after_m, 5.0);
      EXPECT_GT(evidence.verdicts[0].before_m, 2.0 * evidence.verdicts[0].after_m);
      EXPECT_THAT(evidence.unexplained, IsEmpty());
    }
}

TEST(PairEvidence, NamesInvertedPosesWithoutTiePoints) {
  auto survey = testing::simulated_survey();
  const auto matched = matches_of(survey);
  for (auto& frame : survey.frames) frame.T_world_camera = frame.T_world_camera.inverse();
  const auto evidence = pair_evidence(survey, matched);
  ASSERT_THAT(evidence.verdicts, SizeIs(1));
  EXPECT_EQ(evidence.verdicts[0].code, "pose_inverted");
  EXPECT_THAT(evidence.verdicts[0].frames, SizeIs(survey.frames.size()));
}

TEST(PairEvidence, NamesOpenGlAxesWithoutTiePoints) {
  auto survey = testing::simulated_survey();
  const auto matched = matches_of(survey);
  for (auto& frame : survey.frames)
    frame.T_world_camera.rotation = frame.T_world_camera.rotation * Vec3(1, -1, -1).asDiagonal();
  const auto evidence = pair_evidence(survey, matched);
  ASSERT_THAT(evidence.verdicts, SizeIs(1));
  EXPECT_EQ(evidence.verdicts[0].code, "camera_axes_opengl");
}

TEST(PairEvidence, WrongMatchesAreNotExplained) {
  auto survey = testing::simulated_survey();
  auto matched = matches_of(survey);
  base::Random random(3, "wrong matches", 0);
  for (auto& pair : matched)
    if (pair.a.value == 6 || pair.b.value == 6)
      for (auto& match : pair.matches) match.b = {random.uniform(0, 1600), random.uniform(0, 900)};
  const auto evidence = pair_evidence(survey, matched);
  EXPECT_THAT(evidence.verdicts, IsEmpty());
  EXPECT_THAT(evidence.unexplained, ::testing::ElementsAre(FrameId(6)));
}

TEST(PairEvidence, PairsWithoutMatchesAreCountedNotJudged) {
  const auto survey = testing::simulated_survey();
  const auto evidence = pair_evidence(survey, {});
  EXPECT_THAT(evidence.pairs, IsEmpty());
  EXPECT_THAT(evidence.verdicts, IsEmpty());
  EXPECT_THAT(evidence.unmatched, SizeIs(survey.frames.size()));
}

}  // namespace
}  // namespace cairn::adjustment
