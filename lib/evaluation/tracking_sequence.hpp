// Tracks and their truth, frame by frame: what every tracking score is computed from.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/primitives.hpp"

namespace cairn::evaluation {

// A box with an identity, in one frame. Frames are numbers; their order is the order of time.
struct IdentifiedBox {
  std::int64_t frame = 0;
  std::int64_t id = 0;
  geometry::PixelBox box;  // px
};

struct TrueBox {
  std::int64_t frame = 0;
  std::int64_t id = 0;
  geometry::PixelBox box;  // px
  // Not scored: neither missed where it is not tracked, nor false where it is (a track's box that overlaps it and no
  // scored box by the IoU threshold is taken out first).
  bool ignored = false;
};

// One frame with dense ids 0.. of truth and tracks, and the IoU of each pair (truth major).
struct SequenceFrame {
  std::vector<std::size_t> truth, tracks;
  std::vector<double> similarity;

  [[nodiscard]] double at(std::size_t i, std::size_t j) const { return similarity[i * tracks.size() + j]; }
};

struct Sequence {
  std::vector<SequenceFrame> frames;
  std::vector<std::size_t> truth_boxes, track_boxes;   // number of boxes of each id
  std::size_t truths = 0, tracks = 0;                  // number of boxes in all
  std::size_t ignored_truths = 0, ignored_tracks = 0;  // taken out before the scores
};

// Frames in ascending order; ids in ascending order of the numbers given. Boxes of tracks that are matched to ignored
// truth are taken out as TrackEval does for distractor classes: one-to-one assignment of the greatest summed IoU over
// all truth boxes, pairs from `iou_threshold` up.
// Throws invalid_input where an id occurs twice in a frame.
[[nodiscard]] Sequence make_sequence(const std::vector<TrueBox>& truth, const std::vector<IdentifiedBox>& tracks,
                                     double iou_threshold = 0.5);

}  // namespace cairn::evaluation
