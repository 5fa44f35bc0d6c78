#include "adjustment/tracks.hpp"

#include <gmock/gmock.h>

#include <algorithm>

namespace cairn::adjustment {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

TEST(Tracks, JoinsMatchesThroughImages) {
  const std::vector<TrackEdge> edges{{{0, 5}, {1, 7}, 0.9F}, {{1, 7}, {2, 3}, 0.8F}, {{0, 6}, {2, 4}, 0.95F}};
  const auto tracks = build_tracks(edges);
  ASSERT_THAT(tracks.tracks, SizeIs(2));
  EXPECT_THAT(tracks.tracks[0], ElementsAre(TrackNode{0, 5}, TrackNode{1, 7}, TrackNode{2, 3}));
  EXPECT_THAT(tracks.tracks[1], ElementsAre(TrackNode{0, 6}, TrackNode{2, 4}));
  EXPECT_EQ(tracks.refused, 0U);
}

TEST(Tracks, AMatchThatWouldSeeOneImageTwiceIsRefusedAndTheSurerOnesStay) {
  // 0:1 - 1:1 - 2:1 are right; 2:1 - 0:2 is wrong and the least sure.
  const std::vector<TrackEdge> edges{
      {{0, 1}, {1, 1}, 0.9F}, {{1, 1}, {2, 1}, 0.9F}, {{2, 1}, {0, 2}, 0.7F}, {{0, 2}, {3, 2}, 0.8F}};
  const auto tracks = build_tracks(edges);
  EXPECT_EQ(tracks.refused, 1U);
  ASSERT_THAT(tracks.tracks, SizeIs(2));
  EXPECT_THAT(tracks.tracks[0], ElementsAre(TrackNode{0, 1}, TrackNode{1, 1}, TrackNode{2, 1}));
  EXPECT_THAT(tracks.tracks[1], ElementsAre(TrackNode{0, 2}, TrackNode{3, 2}));
}

TEST(Tracks, TheOrderOfTheMatchesDoesNotMatter) {
  std::vector<TrackEdge> edges;
  for (std::uint32_t image = 0; image < 6; ++image)
    for (std::uint32_t feature = 0; feature < 20; ++feature)
      for (std::uint32_t other = image + 1; other < 6; ++other)
        // Every fifth feature is mismatched by one, with varied certainty.
        edges.push_back({{image, feature},
                         {other, feature % 5 == 0 ? (feature + other) % 20 : feature},
                         static_cast<float>((feature * 7 + image * 3 + other) % 11) / 11.0F});
  const auto expected = build_tracks(edges);
  std::reverse(edges.begin(), edges.end());
  for (auto& edge : edges) std::swap(edge.a, edge.b);
  const auto tracks = build_tracks(edges);
  EXPECT_EQ(tracks.tracks, expected.tracks);
  EXPECT_EQ(tracks.refused, expected.refused);
  EXPECT_GT(expected.refused, 0U);
  for (const auto& track : tracks.tracks)
    for (std::size_t i = 1; i < track.size(); ++i) EXPECT_LT(track[i - 1].image, track[i].image);
}

TEST(Tracks, NoMatchesMakeNoTracks) {
  EXPECT_THAT(build_tracks({}).tracks, IsEmpty());
}

}  // namespace
}  // namespace cairn::adjustment
