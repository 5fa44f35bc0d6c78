// Which targets were right to enter each stage of their life, and which objects never did (paper A, Table I).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "base/options.hpp"
#include "survey/detection.hpp"
#include "survey/target.hpp"
#include "survey/truth.hpp"

namespace cairn::evaluation {

struct StageOptions {
  // A sought object counts as missed only where it was seen whole in at least this many frames.
  // 0 = 10 for video (median frame interval up to 1 s), 3 for survey photos or unknown times.
  std::int64_t seen_whole = 0;
  double min_visible_share = 0.5;  // a frame shows the object where at least this share of its outline is not hidden

  void visit(base::OptionVisitor& visitor) {
    visitor.integer("seen-whole", seen_whole, 0, 1'000'000,
                    "frames that must show an object whole before it can be missed; 0 = 10 for video, 3 for photos");
    visitor.real("min-visible-share", min_visible_share, 0.0, 1.0,
                 "share of its outline that must be unhidden for an object to count as seen, 0..1");
  }
};

// Why an entry is true or false.
enum class Verdict {
  right,          // most boxes so far are of one sought object that no earlier target of this stage is of
  duplicate,      // most are of a sought object that an earlier target of this stage is of
  distractor,     // most are of an object that is not sought
  no_object,      // most are false boxes
  no_majority,    // no single origin has more than half of the boxes
  without_boxes,  // it has no box up to the frame of entry
};
[[nodiscard]] std::string_view name_of(Verdict verdict);

struct EntryVerdict {
  survey::TargetId target;
  survey::FrameId frame;
  survey::ObjectId object;  // that most boxes so far are of; invalid where there is none
  Verdict verdict = Verdict::right;
};

struct StageScore {
  survey::TargetState stage = survey::TargetState::generated;
  std::size_t tp = 0, fp = 0, fn = 0;
  std::vector<EntryVerdict> entries;                      // in the order of time, then of target id
  std::vector<survey::ObjectId> missed;                   // the fn objects, ascending
  [[nodiscard]] std::optional<double> precision() const;  // empty where no target entered
  [[nodiscard]] std::optional<double> recall() const;     // empty where there was nothing to find
};

struct StageScores {
  std::array<StageScore, 4> stages;         // generated, converging, converged, mapped
  std::size_t seen_whole = 0;               // the number of frames that was applied
  std::vector<survey::ObjectId> sought;     // sought objects seen whole in enough frames, ascending
  std::size_t other_classes = 0;            // targets left out for their class
  std::size_t without_history = 0;          // targets whose stages were derived from their final state
  std::vector<survey::ObjectId> object_of;  // per target, of all its boxes (strict majority); invalid = none
};

// Scored are targets of the classes that sought objects have, and those without a class: a boulder that is called one
// is no false PBR. Frames are ordered by time, then id (by id alone where truth has no times). A target enters a stage
// once, at its first history entry of that name. A target without history is taken to have entered `generated` and
// every stage up to its final state with all its boxes (`deregistered`: generated only). "Most" = more than half.
// `detections` gives the frame of each box. Boxes whose origin is not in `truth` count as false ones.
// Recall counts objects that entered although they were seen whole in fewer frames as found.
// Cost n log n in boxes and entries.
[[nodiscard]] StageScores score_stages(const std::vector<survey::Target>& targets,
                                       const std::vector<survey::Detection>& detections, const survey::Truth& truth,
                                       const StageOptions& options);

}  // namespace cairn::evaluation
