// Matches of pairs of images joined to tracks of one point through many images.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cairn::adjustment {

// A feature of an image, both by index.
struct TrackNode {
  std::uint32_t image = 0, feature = 0;

  friend auto operator<=>(const TrackNode&, const TrackNode&) = default;
};

struct TrackEdge {
  TrackNode a, b;
  float closeness = 0.0F;  // the surer match is joined first
};

struct Tracks {
  std::vector<std::vector<TrackNode>> tracks;  // at least two nodes, ascending; ordered by their first node
  std::size_t refused = 0;                     // matches that would have put two features of one image in a track
};

// Union-find over the matches in the order of their closeness. A match that would join two features of one image into
// one track is refused, so that a wrong match splits a track and never makes it contradict itself.
// The order of `edges` does not matter. Cost: n log n in the matches.
[[nodiscard]] Tracks build_tracks(std::span<const TrackEdge> edges);

}  // namespace cairn::adjustment
