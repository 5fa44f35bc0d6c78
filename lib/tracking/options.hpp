// Options of the image tracker.
#pragma once

#include <cstdint>
#include <string>

#include "base/options.hpp"

namespace cairn::tracking {

// How the published variants differ: `sort` is the reference implementation, `paper` what paper A runs.
//   sort   min_hits 3, max_age 1, emit_age 0, the streak starts anew after a miss
//   paper  min_hits 10, max_age 100, emit_age 99 (coasted boxes are emitted), misses do not break the streak
struct SortOptions {
  std::string preset = "sort";
  std::int64_t min_hits = -1;  // matches that must follow a track's first box before it is emitted; -1 = preset's
  std::int64_t max_age = -1;   // frames without a match after which a track is dropped (kept while <=); -1 = preset's
  std::int64_t emit_age = -1;  // frames without a match for which its predicted box is emitted, coasted; -1 = preset's
  double iou = 0.3;            // least intersection over union of a match
  std::string streak = "preset";  // reset: a miss starts the streak anew; keep: it does not; preset
  bool early = true;              // in the first min_hits frames every matched track is emitted
  bool class_aware = true;        // boxes of another class never match a track
  double min_score = -1e9;        // boxes with a lower score are not used
  std::string ids = "confirmed";  // confirmed: 1, 2, 3 in the order tracks are first emitted; all: every track counts
  bool keep_duplicates = false;   // use a box that another one of the frame repeats exactly

  void visit(base::OptionVisitor& visitor);
};

// The options with every -1 and "preset" replaced. Throws invalid_argument where one is out of range, or where
// emit_age is above max_age.
[[nodiscard]] SortOptions resolved(SortOptions options);

}  // namespace cairn::tracking
