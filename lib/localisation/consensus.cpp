#include "localisation/consensus.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/parallel.hpp"
#include "geometry/assignment.hpp"
#include "localisation/pool_pairs.hpp"

namespace cairn::localisation {
namespace {

using geometry::Vec3;

constexpr int kRounds = 5;
// Of the boxes of two targets that are joined: a gate of 3.5 sigma takes two boxes of a thousand from their own object.
constexpr double kLostShare = 0.01;
// Of the frames of the lesser of two targets nearly in one place: those with a box of each. A stray box beside the
// object's own must not keep its two halves apart; two objects show in most frames together.
constexpr double kSharedShare = 0.1;
constexpr double kNearShare = 0.5;  // of the lesser size: how near such targets must be
// A track's boxes are strays in a target that has fewer of them than this share of what another target has.
constexpr double kStrayShare = 0.25;
constexpr double kSameObject = 0.25;  // of the size: centres nearer than this are one object, boxes in one frame or not

class Builder {
 public:
  Builder(const PreparedBoxes& prepared, const DepthPrior& depth, const LocateOptions& options,
          const base::RunContext& ctx)
      : prepared_(prepared), options_(options), ctx_(ctx), judge_(prepared, depth, options) {}

  Consensus run(const std::vector<LiveTarget>& seeds) {
    result_.seed_of_box.resize(prepared_.boxes.size());
    std::vector<Candidate> seeded;
    for (const auto& seed : seeds) {
      next_id_ = std::max(next_id_, seed.id.value + 1);
      for (const std::size_t b : seed.boxes) result_.seed_of_box[b] = seed.id;
      Candidate c;
      c.id = seed.id;
      c.object_class = seed.object_class;
      c.boxes = seed.boxes;
      if (c.boxes.size() > 1) seeded.push_back(std::move(c));
    }
    const std::vector<char> fits = refit_all(seeded);
    for (std::size_t i = 0; i < seeded.size(); ++i)
      if (fits[i] != 0) candidates_.push_back(std::move(seeded[i]));
    merge();
    for (int round = 0; round < kRounds; ++round) {
      ctx_.check_stop();
      dissolve_pairs();
      // What a video shows, the tracker has followed; the pairs of its thousands of false boxes would meet everywhere.
      if (!prepared_.video) recover();
      const bool changed = reassign();
      merge();
      if (!changed) break;
    }
    drop_doubles();
    if (prepared_.tracked) drop_strays();
    std::sort(candidates_.begin(), candidates_.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    const auto pool = free_boxes();
    result_.left_over.assign(pool.begin(), pool.end());
    for (auto& c : candidates_) {
      c.visible_frames = frames_showing(prepared_, c, options_).size();
      for (const std::size_t b : c.boxes)
        if (result_.seed_of_box[b].valid() && result_.seed_of_box[b] != c.id) ++result_.moved;
    }
    result_.candidates = std::move(candidates_);
    return std::move(result_);
  }

 private:
  // Triangulates and keeps the consistent boxes. False where fewer than two are left, or the point lies
  // outside the depth range.
  bool refit(Candidate& c) const { return judge_.fit(c); }

  std::vector<char> refit_all(std::vector<Candidate>& candidates) const {
    std::vector<char> fits(candidates.size(), 0);
    base::parallel_for(candidates.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) fits[i] = refit(candidates[i]) ? 1 : 0;
    });
    return fits;
  }

  std::vector<std::size_t> free_boxes() const {
    std::vector<bool> used(prepared_.boxes.size(), false);
    for (const auto& c : candidates_)
      for (const std::size_t b : c.boxes) used[b] = true;
    std::vector<std::size_t> pool;
    for (std::size_t b = 0; b < used.size(); ++b)
      if (!used[b]) pool.push_back(b);
    return pool;
  }

  // The boxes of both, and those of `b` alone left out that lie in frames of `a`. Both lists ascend, and with them the
  // frames.
  struct Union {
    std::vector<std::size_t> boxes;
    std::size_t shared_frames = 0;
  };
  Union unite(const Candidate& a, const Candidate& b) const {
    Union all{a.boxes, 0};
    std::size_t i = 0;
    for (const std::size_t box : b.boxes) {
      const std::size_t frame = prepared_.boxes[box].frame;
      while (i < a.boxes.size() && prepared_.boxes[a.boxes[i]].frame < frame) ++i;
      if (i < a.boxes.size() && prepared_.boxes[a.boxes[i]].frame == frame) ++all.shared_frames;
      else all.boxes.push_back(box);
    }
    return all;
  }

  void sort_by_east() {
    std::stable_sort(candidates_.begin(), candidates_.end(), [](const auto& a, const auto& b) {
      return a.fix.centre.x() != b.fix.centre.x() ? a.fix.centre.x() < b.fix.centre.x() : a.id < b.id;
    });
  }

  // Pairs near enough to be one object, over candidates sorted by east. `act` returns true when it removed the second.
  template <typename Act>
  void for_near_pairs(const Act& act) {
    sort_by_east();
    double widest = 0.0;
    for (const auto& c : candidates_) widest = std::max(widest, c.size_m + wander(c));
    std::vector<bool> gone(candidates_.size(), false);
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      for (std::size_t j = i + 1; j < candidates_.size() && !gone[i]; ++j) {
        if (candidates_[j].fix.centre.x() - candidates_[i].fix.centre.x() > 2.0 * widest) break;
        if (gone[j] || candidates_[i].object_class != candidates_[j].object_class) continue;
        if (act(candidates_[i], candidates_[j])) gone[j] = true;
      }
    std::vector<Candidate> kept;
    for (std::size_t i = 0; i < candidates_.size(); ++i)
      if (!gone[i]) kept.push_back(std::move(candidates_[i]));
    candidates_ = std::move(kept);
  }

  // How far the positions of a video may have wandered between two passes, 3 sigma [m]: errors of all frames of a pass
  // in common, so that the fix's own covariance does not know them. The joint fit must still hold.
  double wander(const Candidate& c) const {
    return prepared_.video ? 3.0 * prepared_.frames[prepared_.boxes[c.boxes.front()].frame].sigma_xy_m : 0.0;
  }

  void merge() {
    for_near_pairs([this](Candidate& a, Candidate& b) {
      const double distance = (a.fix.centre - b.fix.centre).norm();
      const double spread = 3.0 * std::sqrt(a.fix.covariance.trace() + b.fix.covariance.trace());
      const double limit = std::max({a.size_m, b.size_m, spread, wander(a), wander(b)});
      if (distance > limit) return false;
      const bool larger = a.boxes.size() >= b.boxes.size();
      auto all = larger ? unite(a, b) : unite(b, a);
      const auto few = static_cast<double>(std::min(a.boxes.size(), b.boxes.size()));
      if (static_cast<double>(all.shared_frames) > kSharedShare * few) return false;
      if (all.shared_frames > 0 && distance > kNearShare * std::min(a.size_m, b.size_m)) return false;
      Candidate joined = larger ? a : b;
      joined.id = std::min(a.id, b.id);
      joined.boxes = std::move(all.boxes);
      const auto together = static_cast<double>(joined.boxes.size());
      if (!refit(joined) || static_cast<double>(joined.boxes.size()) < (1.0 - kLostShare) * together) return false;
      a = std::move(joined);
      ++result_.merged;
      return true;
    });
  }

  // One object boxed twice in the same frames: the target with more boxes stays.
  void drop_doubles() {
    for_near_pairs([this](Candidate& a, Candidate& b) {
      const double limit = kSameObject * std::min(a.size_m, b.size_m);
      if ((a.fix.centre - b.fix.centre).norm() > limit) return false;
      if (b.boxes.size() > a.boxes.size() || (b.boxes.size() == a.boxes.size() && b.id < a.id)) std::swap(a, b);
      ++result_.merged;
      return true;
    });
  }

  // Boxes of a track that follows another target: they lie on the line of sight of this one for a while.
  void drop_strays() {
    std::map<survey::TrackId, std::map<std::size_t, std::size_t>> holders;  // track -> candidate -> boxes
    for (std::size_t c = 0; c < candidates_.size(); ++c)
      for (const std::size_t b : candidates_[c].boxes) ++holders[prepared_.boxes[b].track][c];
    std::vector<Candidate> cleared = candidates_;
    std::vector<bool> touched(candidates_.size(), false);
    for (std::size_t c = 0; c < cleared.size(); ++c) {
      const auto gone = std::erase_if(cleared[c].boxes, [&](std::size_t b) {
        const auto& held = holders[prepared_.boxes[b].track];
        return std::any_of(held.begin(), held.end(), [&](const auto& other) {
          return static_cast<double>(held.at(c)) < kStrayShare * static_cast<double>(other.second);
        });
      });
      touched[c] = gone > 0;
    }
    for (std::size_t c = 0; c < cleared.size(); ++c)
      if (touched[c] && refit(cleared[c])) candidates_[c] = std::move(cleared[c]);
  }

  // Two boxes always meet nearly somewhere: such targets stand for election again, beside the other pool boxes.
  void dissolve_pairs() {
    std::erase_if(candidates_, [](const Candidate& c) { return c.boxes.size() < 3; });
  }

  void recover() {
    std::set<survey::TargetId> used;
    for (const auto& c : candidates_) used.insert(c.id);
    for (auto& c : candidates_from_pool(prepared_, judge_, free_boxes(), options_)) {
      // The oldest of its boxes' former targets gives the name; a new one only where all are in use.
      survey::TargetId id;
      for (const std::size_t b : c.boxes) {
        const auto seed = result_.seed_of_box[b];
        if (seed.valid() && !used.contains(seed) && (!id.valid() || seed < id)) id = seed;
      }
      if (!id.valid()) id = survey::TargetId(next_id_++);
      used.insert(id);
      c.id = id;
      if (c.boxes.size() > 2) ++result_.recovered;
      candidates_.push_back(std::move(c));
    }
  }

  // All boxes to all candidates, frame by frame. True where some candidate's boxes changed.
  bool reassign() {
    std::vector<std::vector<std::size_t>> boxes_of(candidates_.size());
    const double gate2 = options_.box_gate * options_.box_gate;
    for (const auto& frame : prepared_.frames) {
      std::vector<std::size_t> boxes = frame.boxes;
      boxes.insert(boxes.end(), frame.cut_boxes.begin(), frame.cut_boxes.end());
      if (boxes.empty()) continue;
      std::vector<std::size_t> rows;
      std::vector<double> score;
      for (std::size_t c = 0; c < candidates_.size(); ++c) {
        const auto at = appearance(frame, candidates_[c].fix.centre, candidates_[c].fix.covariance);
        if (!at) continue;
        std::vector<double> row;
        bool any = false;
        for (std::size_t b = 0; b < boxes.size(); ++b) {
          const Box& box = prepared_.boxes[boxes[b]];
          if (candidates_[c].object_class != box.object_class) continue;
          const double d2 = squared_distance(*at, box.centre_px, box.sigma_px);
          if (!(d2 <= gate2) || !judge_.fits_size(boxes[b], candidates_[c].fix.centre, candidates_[c].size_m)) continue;
          row.resize(boxes.size(), 0.0);
          row[b] = 1.0 + (gate2 - d2) / gate2;
          any = true;
        }
        if (!any) continue;
        rows.push_back(c);
        score.insert(score.end(), row.begin(), row.end());
      }
      if (rows.empty()) continue;
      std::vector<double> cost(score.size());
      std::transform(score.begin(), score.end(), cost.begin(), [](double s) { return -s; });
      const auto pairs = geometry::assign(cost, rows.size(), boxes.size());
      for (std::size_t r = 0; r < rows.size(); ++r)
        if (pairs[r] != geometry::kUnassigned && score[r * boxes.size() + pairs[r]] > 0.0)
          boxes_of[rows[r]].push_back(boxes[pairs[r]]);
    }
    std::vector<Candidate> next = candidates_;
    for (std::size_t c = 0; c < next.size(); ++c) next[c].boxes = std::move(boxes_of[c]);
    const std::vector<char> fits = refit_all(next);
    bool changed = false;
    std::vector<Candidate> kept;
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      changed = changed || fits[c] == 0 || next[c].boxes != candidates_[c].boxes;
      if (fits[c] != 0) kept.push_back(std::move(next[c]));
    }
    candidates_ = std::move(kept);
    return changed;
  }

  const PreparedBoxes& prepared_;
  const LocateOptions& options_;
  const base::RunContext& ctx_;
  BoxJudge judge_;
  std::vector<Candidate> candidates_;
  Consensus result_;
  std::int64_t next_id_ = 1;
};

}  // namespace

std::optional<double> noise_scale(const PreparedBoxes& prepared, const Consensus& consensus) {
  constexpr double kLeastRedundancy = 50.0;
  double squares = 0.0, redundancy = 0.0;
  for (const auto& c : consensus.candidates) {
    double count = 0.0, sum = 0.0;
    for (const std::size_t b : c.boxes) {
      const Box& box = prepared.boxes[b];
      if (box.cut) continue;  // their large errors would hide what the others say
      const auto d2 = squared_distance({&prepared.frames[box.frame], box.centre_px, box.sigma_px, box.cut},
                                       c.fix.centre, geometry::Mat3::Zero());
      if (!d2) continue;
      sum += *d2;
      count += 1.0;
    }
    if (count < 3.0) continue;
    squares += sum;
    redundancy += 2.0 * count - 3.0;
  }
  if (redundancy < kLeastRedundancy || !(squares > 0.0)) return std::nullopt;
  return std::sqrt(squares / redundancy);
}

Consensus find_consensus(const PreparedBoxes& prepared, const DepthPrior& depth, const std::vector<LiveTarget>& seeds,
                         const LocateOptions& options, const base::RunContext& ctx) {
  return Builder(prepared, depth, options, ctx).run(seeds);
}

}  // namespace cairn::localisation
