// SORT: boxes of successive images joined to tracks.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "tracking/box_filter.hpp"
#include "tracking/box_matching.hpp"
#include "tracking/options.hpp"
#include "tracking/screen.hpp"

namespace cairn::tracking {

// A track's box in the frame just stepped.
struct TrackedObservation {
  std::int64_t id = 0;     // from 1
  geometry::PixelBox box;  // the filter's estimate, px; finite
  int object_class = 0;
  double score = 0.0;                  // of the box matched last
  std::size_t observation = kNoMatch;  // index into the step's boxes; kNoMatch where coasted
  [[nodiscard]] bool coasted() const { return observation == kNoMatch; }
};

// Bewley et al. 2016 (arXiv:1602.00763) as its public implementation behaves, step by step:
//   every track is predicted (dropped where the prediction is not finite); boxes and predictions are matched
//   (match_boxes); matched tracks are updated; boxes left over start tracks, whose streak of matches is 0; tracks are
//   emitted from the youngest to the oldest; a track is dropped once its frames without a match exceed max_age.
// A track is emitted where its frames without a match are <= emit_age and its streak is >= min_hits (or, with `early`,
// in the first min_hits frames of the sequence).
// Beside that: time steps other than 1, classes, scores, ids of emitted tracks only. Deterministic.
// Cost of a step: boxes x live tracks.
class SortTracker {
 public:
  // Throws as `resolved` does.
  explicit SortTracker(const SortOptions& options);

  // One frame. boxes: finite, of positive area (screen_boxes). dt: since the frame before, in nominal frame periods,
  // > 0. The result is valid until the next call.
  std::span<const TrackedObservation> step(std::span<const BoxObservation> boxes, double dt = 1.0);

  // Ends every track: the next boxes start new ones. Counts as no frame.
  void end_tracks() { tracks_.clear(); }
  // Counts frames in which nothing can happen, as no track is alive. Throws internal where one is.
  void skip_frames(std::int64_t count);
  [[nodiscard]] bool idle() const { return tracks_.empty(); }

  [[nodiscard]] std::int64_t tracks_started() const { return started_; }
  [[nodiscard]] std::int64_t tracks_emitted() const { return emitted_; }
  // Tracks dropped because their prediction or estimate was not a finite box.
  [[nodiscard]] std::int64_t non_finite_tracks() const { return non_finite_; }

 private:
  struct Track {
    BoxFilter filter;
    int object_class = 0;
    double score = 0.0;
    std::int64_t id = 0;  // 0 = not given yet
    std::int64_t streak = 0, missed = 0;
    bool emitted = false;
    std::size_t observation = kNoMatch;
  };

  void predict(double dt);
  void start_track(const BoxObservation& o, std::size_t index);
  void emit();

  SortOptions options_;
  std::vector<Track> tracks_;
  std::vector<ClassedBox> predicted_, detections_;
  std::vector<TrackedObservation> output_;
  std::int64_t frame_ = 0, started_ = 0, emitted_ = 0, non_finite_ = 0;
  bool reset_streak_ = true, confirmed_ids_ = true;
};

}  // namespace cairn::tracking
