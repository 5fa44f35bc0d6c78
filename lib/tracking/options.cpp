#include "tracking/options.hpp"

#include "base/error.hpp"

namespace cairn::tracking {

void SortOptions::visit(base::OptionVisitor& visitor) {
  visitor.choice("preset", preset, {"sort", "paper"},
                 "sort: the reference implementation (3, 1, 0); paper: paper A's values (10, 100, 99, streak kept)");
  visitor.integer("min-hits", min_hits, -1, 1'000'000,
                  "matches that must follow a track's first box before it is emitted; -1 = the preset's");
  visitor.integer("max-age", max_age, -1, 1'000'000,
                  "frames without a match after which a track is dropped; -1 = the preset's");
  visitor.integer("emit-age", emit_age, -1, 1'000'000,
                  "frames without a match for which the predicted box is emitted as coasted; -1 = the preset's");
  visitor.real("iou", iou, 0.0, 1.0, "least intersection over union of a match");
  visitor.choice("streak", streak, {"preset", "reset", "keep"}, "whether a miss starts the count of matches anew");
  visitor.flag("early", early, "in the first min-hits frames, emit every matched track");
  visitor.flag("class-aware", class_aware, "a box of another class never matches a track");
  visitor.real("min-score", min_score, -1e9, 1e9, "boxes with a lower score are not used");
  visitor.choice("ids", ids, {"confirmed", "all"},
                 "confirmed: identities 1, 2, 3 without gaps; all: tracks that are never emitted count too");
  visitor.flag("keep-duplicates", keep_duplicates, "use a box that repeats another one of its frame exactly");
}

SortOptions resolved(SortOptions options) {
  base::validate(base::bind_options(options), "track");
  const bool paper = options.preset == "paper";
  if (options.min_hits < 0) options.min_hits = paper ? 10 : 3;
  if (options.max_age < 0) options.max_age = paper ? 100 : 1;
  // The published node emits while time since the update < max_age.
  if (options.emit_age < 0) options.emit_age = paper && options.max_age > 0 ? options.max_age - 1 : 0;
  if (options.streak == "preset") options.streak = paper ? "keep" : "reset";
  if (options.emit_age > options.max_age)
    throw base::Error(base::ErrorCode::invalid_argument, "track: --emit-age is above --max-age")
        .found(std::to_string(options.emit_age))
        .allowed("0 to " + std::to_string(options.max_age))
        .hint("A track that was dropped has no box to emit: raise --max-age");
  return options;
}

}  // namespace cairn::tracking
