#include "tracking/sort.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace cairn::tracking {
namespace {

bool finite(const geometry::PixelBox& b) {
  return std::isfinite(b.xmin) && std::isfinite(b.ymin) && std::isfinite(b.xmax) && std::isfinite(b.ymax);
}

}  // namespace

SortTracker::SortTracker(const SortOptions& options)
    : options_(resolved(options)),
      reset_streak_(options_.streak == "reset"),
      confirmed_ids_(options_.ids == "confirmed") {}

void SortTracker::skip_frames(std::int64_t count) {
  if (!idle()) throw base::Error(base::ErrorCode::internal, "frames skipped while a track is alive");
  frame_ += count;
}

void SortTracker::predict(double dt) {
  predicted_.clear();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    track.filter.predict(dt);
    if (track.missed > 0 && reset_streak_) track.streak = 0;
    ++track.missed;
    track.observation = kNoMatch;
    const geometry::PixelBox box = track.filter.box();
    if (!finite(box)) {
      ++non_finite_;
      continue;
    }
    predicted_.push_back({box, options_.class_aware ? track.object_class : 0});
    if (kept != i) tracks_[kept] = track;
    ++kept;
  }
  tracks_.erase(tracks_.begin() + static_cast<std::ptrdiff_t>(kept), tracks_.end());
}

void SortTracker::start_track(const BoxObservation& o, std::size_t index) {
  Track track{BoxFilter(o.box), o.object_class, o.score, 0, 0, 0, false, index};
  ++started_;
  if (!confirmed_ids_) track.id = started_;
  tracks_.push_back(track);
}

void SortTracker::emit() {
  output_.clear();
  const auto wanted = [&](const Track& t) {
    return t.missed <= options_.emit_age &&
           (t.streak >= options_.min_hits || (options_.early && frame_ <= options_.min_hits));
  };
  for (Track& t : tracks_) {
    if (t.emitted || !wanted(t)) continue;
    t.emitted = true;
    ++emitted_;
    if (confirmed_ids_) t.id = emitted_;
  }
  for (std::size_t i = tracks_.size(); i-- > 0;) {
    const Track& t = tracks_[i];
    if (!wanted(t)) continue;
    const geometry::PixelBox box = t.filter.box();
    if (finite(box)) output_.push_back({t.id, box, t.object_class, t.score, t.observation});
  }
}

std::span<const TrackedObservation> SortTracker::step(std::span<const BoxObservation> boxes, double dt) {
  ++frame_;
  predict(dt);
  detections_.clear();
  for (const auto& o : boxes) detections_.push_back({o.box, options_.class_aware ? o.object_class : 0});
  const auto track_of = match_boxes(detections_, predicted_, options_.iou);
  for (std::size_t d = 0; d < boxes.size(); ++d) {
    if (track_of[d] == kNoMatch) continue;
    Track& track = tracks_[track_of[d]];
    track.filter.update(boxes[d].box);
    track.missed = 0;
    ++track.streak;
    track.score = boxes[d].score;
    track.observation = d;
  }
  for (std::size_t d = 0; d < boxes.size(); ++d)
    if (track_of[d] == kNoMatch) start_track(boxes[d], d);
  emit();
  std::erase_if(tracks_, [&](const Track& t) { return t.missed > options_.max_age; });
  return output_;
}

}  // namespace cairn::tracking
