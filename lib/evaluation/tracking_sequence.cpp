#include "evaluation/tracking_sequence.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "base/error.hpp"
#include "evaluation/box_overlap.hpp"
#include "geometry/assignment.hpp"

namespace cairn::evaluation {
namespace {

struct RawFrame {
  std::vector<const TrueBox*> truth;
  std::vector<const IdentifiedBox*> tracks;
};

template <typename Box>
void refuse_repeats(const std::vector<const Box*>& boxes, const char* what) {
  std::set<std::int64_t> seen;
  for (const auto* box : boxes)
    if (!seen.insert(box->id).second)
      throw base::Error(base::ErrorCode::invalid_input, "an identity has two boxes in one frame")
          .record(std::string(what) + ", frame " + std::to_string(box->frame) + ", id " + std::to_string(box->id))
          .allowed("one box for each identity and frame");
}

// Boxes of tracks that stand for ignored truth.
std::size_t take_out_ignored(RawFrame& frame, double iou_threshold) {
  if (std::none_of(frame.truth.begin(), frame.truth.end(), [](const auto* t) { return t->ignored; })) return 0;
  std::set<std::size_t> out;
  if (!frame.tracks.empty()) {
    std::vector<double> cost;
    for (const auto* t : frame.truth)
      for (const auto* k : frame.tracks) {
        const double overlap = iou(t->box, k->box);
        cost.push_back(overlap >= iou_threshold ? -overlap : 0.0);
      }
    const auto columns = geometry::assign(cost, frame.truth.size(), frame.tracks.size());
    for (std::size_t i = 0; i < columns.size(); ++i)
      if (columns[i] != geometry::kUnassigned && cost[i * frame.tracks.size() + columns[i]] < 0.0 &&
          frame.truth[i]->ignored)
        out.insert(columns[i]);
  }
  std::vector<const IdentifiedBox*> kept;
  for (std::size_t j = 0; j < frame.tracks.size(); ++j)
    if (!out.contains(j)) kept.push_back(frame.tracks[j]);
  frame.tracks = std::move(kept);
  std::erase_if(frame.truth, [](const auto* t) { return t->ignored; });
  return out.size();
}

}  // namespace

Sequence make_sequence(const std::vector<TrueBox>& truth, const std::vector<IdentifiedBox>& tracks,
                       double iou_threshold) {
  std::map<std::int64_t, RawFrame> frames;
  Sequence sequence;
  for (const auto& box : truth) {
    frames[box.frame].truth.push_back(&box);
    sequence.ignored_truths += box.ignored ? 1U : 0U;
  }
  for (const auto& box : tracks) frames[box.frame].tracks.push_back(&box);
  std::map<std::int64_t, std::size_t> truth_ids, track_ids;
  for (auto& [number, frame] : frames) {
    refuse_repeats(frame.truth, "truth");
    refuse_repeats(frame.tracks, "tracks");
    sequence.ignored_tracks += take_out_ignored(frame, iou_threshold);
    for (const auto* box : frame.truth) truth_ids.emplace(box->id, 0);
    for (const auto* box : frame.tracks) track_ids.emplace(box->id, 0);
  }
  const auto number = [](auto& ids) {
    std::size_t next = 0;
    for (auto& [id, index] : ids) index = next++;
  };
  number(truth_ids);
  number(track_ids);
  sequence.truth_boxes.assign(truth_ids.size(), 0);
  sequence.track_boxes.assign(track_ids.size(), 0);
  for (const auto& [frame_number, raw] : frames) {
    SequenceFrame frame;
    for (const auto* t : raw.truth) {
      frame.truth.push_back(truth_ids.at(t->id));
      ++sequence.truth_boxes[frame.truth.back()];
      for (const auto* k : raw.tracks) frame.similarity.push_back(iou(t->box, k->box));
    }
    for (const auto* k : raw.tracks) {
      frame.tracks.push_back(track_ids.at(k->id));
      ++sequence.track_boxes[frame.tracks.back()];
    }
    sequence.truths += frame.truth.size();
    sequence.tracks += frame.tracks.size();
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace cairn::evaluation
