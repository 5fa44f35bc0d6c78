// Obstacles over time, from the packets of the aircraft: what is there, what is gone, what moves.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "base/reject.hpp"
#include "ground/class_table.hpp"
#include "survey/obstacle.hpp"
#include "survey/packet.hpp"

namespace cairn::ground {

// Paper B gives no rule for association, decay or clearing (B13); all values are ours.
struct ObstacleMapOptions {
  std::string memory = "as_mode";  // paper: the union of all objects ever sent; robust: association over time;
                                   //   as_mode: robust here, of a command the one of its --mode
  ClassTable classes;              // kinds of the classes; visited apart
  // Association.
  double gate_sigma = 3.5;       // Mahalanobis distance of a pair (99.8 % in two dimensions)
  double max_gate_m = 3.0;       // and never farther than this (paper B's error bound for raised objects)
  double systematic_m = 0.1;     // 1 sigma, level, of what several looks have in common (pose, outline): added to a
                                 //   pair's covariance and to every reported one, as it does not average out
  double unknown_sigma_m = 0.5;  // of an object whose covariance was not sent (paper B: within +-1.5 m)
  double class_penalty = 4.0;    // added to the squared distance of a pair of different classes of one kind
  double merge_fraction = 0.5;   // two obstacles nearer than this part of their mean width are one
  // Evidence, in the logarithm of the odds of being there.
  double detection_probability = 0.6;  // an object that is there and in view is detected
  double false_probability = 0.1;      // one that is not there is
  double confirm_probability = 0.95;   // reported from here on: two looks with the values above
  double drop_probability = 0.6;       // and until it falls below this
  double clear_probability = 0.2;      // forgotten below
  double most_probability = 0.99;      // evidence saturates, so that what is gone is dropped after 6 empty looks
  double footprint_margin_m = 0.5;     // an unseen object counts as missed where it lies so far inside the image's
                                       //   ground, with half its width
  double half_life_s = 0.0;            // of the evidence while an object is not in view; 0 = it stays
  // Motion.
  bool motion = true;
  double motion_window_s = 3.0;    // velocity: a straight line through the looks of this time
  double min_speed_m_s = 0.15;     // slower objects are at rest
  double max_speed_m_s = 4.0;      // faster lines are chance
  double motion_chi2 = 18.0;       // fall of the squared residuals, line against point, that makes an object moving
                                   //   (chance of 1 in 8000 for one at rest)
  double acceleration_m_s2 = 0.3;  // 1 sigma: widens the gate of a moving object
  double moving_timeout_s = 5.0;   // a moving object not seen for longer is forgotten

  void visit(base::OptionVisitor& visitor);
};

struct PacketReport {
  std::size_t associated = 0, born = 0, missed = 0, cleared = 0, merged = 0;
  // duplicate_packet; of objects: bad_position, bad_covariance (not finite, or not positive semi-definite), bad_size.
  std::vector<base::Reject> rejects;
};

// Online and offline: feed packets as they come. Late ones (older than the newest) are taken in at their capture time:
// they add to resting objects as if they had come in order, and never count as a miss of what was seen since.
// Ids are given in the order of birth from first_id and never used again; a merge keeps the older. Vehicles in the
// packets are followed as kind `vehicle`.
// Deterministic in the order of the calls. Cost of one packet with n objects: n times the obstacles within the gate,
// plus the assignment (n^2 (n + those)). Memory: about 1 kB an obstacle.
class ObstacleMap {
 public:
  // Validates; throws invalid_argument.
  explicit ObstacleMap(ObstacleMapOptions options = {}, std::int64_t first_id = 1);
  ~ObstacleMap();
  ObstacleMap(ObstacleMap&&) noexcept;
  ObstacleMap& operator=(ObstacleMap&&) noexcept;

  PacketReport add(const survey::Packet& packet);

  // Confirmed obstacles (reported, by the probabilities above) as known at now_ns, in ascending id. Local ENU, m. A
  // moving one has its velocity; its position holds at last_seen_ns. confirmed = false: those seen too seldom as well.
  [[nodiscard]] std::vector<survey::Obstacle> obstacles(std::int64_t now_ns, bool confirmed = true) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::ground
