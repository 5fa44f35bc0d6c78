#include "evaluation/target_stages.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <unordered_map>

namespace cairn::evaluation {
namespace {

using survey::DetectionId;
using survey::FrameId;
using survey::ObjectId;
using survey::TargetState;

constexpr std::array<TargetState, 4> kStages{TargetState::generated, TargetState::converging, TargetState::converged,
                                             TargetState::mapped};
constexpr std::int64_t kVideoFrames = 10, kPhotoFrames = 3;
constexpr std::int64_t kLongestVideoStep = 1'000'000'000;  // ns

// Position of each frame in the order of time.
class FrameOrder {
 public:
  explicit FrameOrder(const std::vector<survey::Frame>& frames) {
    std::vector<const survey::Frame*> order;
    for (const auto& frame : frames) order.push_back(&frame);
    std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) { return a->time_ns < b->time_ns; });
    for (std::size_t i = 0; i < order.size(); ++i) rank_[order[i]->id] = static_cast<std::int64_t>(i);
  }
  // Frames that truth does not know come last, by id.
  [[nodiscard]] std::pair<std::int64_t, std::int64_t> of(FrameId frame) const {
    const auto found = rank_.find(frame);
    return {found == rank_.end() ? std::numeric_limits<std::int64_t>::max() : found->second, frame.value};
  }

 private:
  std::unordered_map<FrameId, std::int64_t> rank_;
};

bool is_video(const std::vector<survey::Frame>& frames) {
  std::vector<std::int64_t> times, steps;
  for (const auto& frame : frames) times.push_back(frame.time_ns);
  std::sort(times.begin(), times.end());
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  if (steps.empty() || times.front() == times.back()) return false;
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  return steps[steps.size() / 2] <= kLongestVideoStep;
}

struct Majority {
  ObjectId object;
  Verdict verdict = Verdict::right;  // right, no_object, no_majority or without_boxes
};

Majority majority(const std::vector<ObjectId>& origins) {
  if (origins.empty()) return {{}, Verdict::without_boxes};
  std::map<ObjectId, std::size_t> votes;
  for (const auto object : origins) ++votes[object];
  for (const auto& [object, count] : votes)
    if (2 * count > origins.size()) return {object, object.valid() ? Verdict::right : Verdict::no_object};
  return {{}, Verdict::no_majority};
}

// The frame at which each stage was entered, if it was.
using Entries = std::array<std::optional<FrameId>, kStages.size()>;

Entries entries_of(const survey::Target& target, std::optional<FrameId> last_frame) {
  Entries entries;
  for (const auto& entry : target.history)
    for (std::size_t s = 0; s < kStages.size(); ++s)
      if (entry.state == kStages[s] && !entries[s]) entries[s] = entry.frame;
  if (!target.history.empty()) return entries;
  for (std::size_t s = 0; s < kStages.size(); ++s) {
    const bool reached = target.state == TargetState::deregistered ? s == 0 : kStages[s] <= target.state;
    if (reached) entries[s] = last_frame.value_or(FrameId());
  }
  return entries;
}

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::right: return "right";
    case Verdict::duplicate: return "duplicate";
    case Verdict::distractor: return "distractor";
    case Verdict::no_object: return "no_object";
    case Verdict::no_majority: return "no_majority";
    case Verdict::without_boxes: return "without_boxes";
  }
  return "";
}

std::optional<double> StageScore::precision() const {
  if (tp + fp == 0) return std::nullopt;
  return static_cast<double>(tp) / static_cast<double>(tp + fp);
}

std::optional<double> StageScore::recall() const {
  if (tp + fn == 0) return std::nullopt;
  return static_cast<double>(tp) / static_cast<double>(tp + fn);
}

StageScores score_stages(const std::vector<survey::Target>& targets, const std::vector<survey::Detection>& detections,
                         const survey::Truth& truth, const StageOptions& options) {
  const FrameOrder order(truth.frames);
  std::unordered_map<DetectionId, FrameId> frame_of;
  for (const auto& detection : detections) frame_of[detection.id] = detection.frame;
  std::unordered_map<DetectionId, ObjectId> origin_of;
  for (const auto& origin : truth.detections) origin_of[origin.detection] = origin.object;
  std::set<ObjectId> sought;
  std::set<std::string> classes;
  for (const auto& object : truth.objects)
    if (object.sought) {
      sought.insert(object.id);
      classes.insert(object.object_class);
    }

  StageScores scores;
  const std::int64_t automatic = is_video(truth.frames) ? kVideoFrames : kPhotoFrames;
  scores.seen_whole = static_cast<std::size_t>(options.seen_whole > 0 ? options.seen_whole : automatic);
  std::map<ObjectId, std::set<FrameId>> seen;
  for (const auto& box : truth.boxes)
    if (box.whole && box.visible_share >= options.min_visible_share && sought.contains(box.object))
      seen[box.object].insert(box.frame);
  for (const auto& [object, frames] : seen)
    if (frames.size() >= scores.seen_whole) scores.sought.push_back(object);

  std::array<std::vector<EntryVerdict>, kStages.size()> entered;
  for (const auto& target : targets) {
    // Boxes in the order of time; those of unknown frames belong to no moment and are left out.
    std::vector<std::pair<std::pair<std::int64_t, std::int64_t>, ObjectId>> boxes;
    std::optional<FrameId> last;
    for (const auto id : target.detections) {
      const auto frame = frame_of.find(id);
      if (frame == frame_of.end()) continue;
      const auto origin = origin_of.find(id);
      boxes.emplace_back(order.of(frame->second), origin == origin_of.end() ? ObjectId() : origin->second);
      if (!last || order.of(*last) < order.of(frame->second)) last = frame->second;
    }
    std::vector<ObjectId> all;
    for (const auto& box : boxes) all.push_back(box.second);
    scores.object_of.push_back(majority(all).object);
    if (!target.object_class.empty() && !classes.contains(target.object_class)) {
      ++scores.other_classes;
      continue;
    }
    if (target.history.empty()) ++scores.without_history;
    const Entries entries = entries_of(target, last);
    for (std::size_t s = 0; s < kStages.size(); ++s) {
      if (!entries[s]) continue;
      const bool whole_life = target.history.empty();
      std::vector<ObjectId> so_far;
      for (const auto& [when, object] : boxes)
        if (whole_life || when <= order.of(*entries[s])) so_far.push_back(object);
      const Majority most = majority(so_far);
      entered[s].push_back({target.id, *entries[s], most.object, most.verdict});
    }
  }

  for (std::size_t s = 0; s < kStages.size(); ++s) {
    StageScore& score = scores.stages[s];
    score.stage = kStages[s];
    score.entries = std::move(entered[s]);
    std::stable_sort(score.entries.begin(), score.entries.end(), [&](const EntryVerdict& a, const EntryVerdict& b) {
      return std::pair(order.of(a.frame), a.target) < std::pair(order.of(b.frame), b.target);
    });
    std::set<ObjectId> found;
    for (auto& entry : score.entries) {
      if (entry.verdict == Verdict::right) {
        if (!sought.contains(entry.object)) entry.verdict = Verdict::distractor;
        else if (!found.insert(entry.object).second) entry.verdict = Verdict::duplicate;
      }
      ++(entry.verdict == Verdict::right ? score.tp : score.fp);
    }
    for (const auto object : scores.sought)
      if (!found.contains(object)) score.missed.push_back(object);
    score.fn = score.missed.size();
  }
  return scores;
}

}  // namespace cairn::evaluation
