// Where the ground vehicle is: its inertial log and the positions at which the aircraft sees it (paper B, 3.5).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/options.hpp"
#include "ground/pose_state.hpp"
#include "survey/ground_vehicle.hpp"
#include "survey/packet.hpp"

namespace cairn::ground {

struct PoseFilterOptions {
  // paper: (B.5) to (B.8), a packet counts when it arrives; robust: at its capture time, with the log's errors
  // estimated.
  std::string mode = "robust";

  // Projected positions, (B.8).
  double projector_sigma_m = 0.5;  // 1 sigma per axis where the packet gives no covariance, and always in paper mode
  double min_projector_sigma_m = 0.1;  // robust: no projected position is better than this

  // False vehicles (B11).
  double max_speed_m_s = 3.0;  // what the vehicle can do; the paper gives none
  double jump_margin_m = 1.5;  // beyond the way at that speed: 3 sigma of the projector
  double gate_sigma = 4.0;     // robust: Mahalanobis gate, 1 in 3000 true positions lies beyond
  std::int64_t recovery_packets =
      8;  // robust: so many refused positions in a row that come along move the estimate there

  // Start: the log's first position.
  double initial_sigma_m = 1.5;  // 1 sigma per axis where the log gives no covariance: paper B's INS alone

  // The log's errors, robust mode (simulation/inertial_log.hpp makes such logs).
  double velocity_noise_m_s = 0.05;  // 1 sigma per sample and axis
  double sample_interval_s = 0.0;    // between the samples that this noise belongs to; 0 = 0.02 (50 Hz)
  double bias_sigma_m_s = 0.02;      // drifting bias, stationary 1 sigma per axis
  double bias_time_s = 50.0;         // its correlation time
  double heading_sigma_deg = 1.0;    // drifting heading error, stationary 1 sigma; turns the velocity
  double heading_time_s = 50.0;      // its correlation time

  // Paper mode: w and w' of (B.5), (B.6), 1 sigma per step and axis; the paper gives none.
  double paper_sigma_position_m = 0.01;
  double paper_sigma_velocity_m_s = 0.05;

  // Gaps and late packets.
  double max_gap_s = 0.0;      // between two samples; longer ones count as gaps; 0 = 10 sample intervals
  double gap_sigma_m_s = 0.5;  // of the velocity in a gap, robust
  double buffer_s = 10.0;      // robust: how late a packet may come

  void visit(base::OptionVisitor& visitor);
};

// What became of one projected position, or of a packet without any (candidate -1).
struct PoseUpdate {
  std::size_t packet = 0;  // index in the order in which packets were given
  std::uint32_t sequence = 0;
  int candidate = -1;  // index in Packet::vehicles
  std::int64_t capture_time_ns = 0, arrival_time_ns = 0;
  geometry::Vec2 position = geometry::Vec2::Zero();  // projected, m
  geometry::Vec2 residual = geometry::Vec2::Zero();  // projected minus predicted at the time it counts for, m
  double gate = 0.0;                                 // Mahalanobis distance of the residual, sigmas
  bool accepted = false;
  // Reason code of a refusal: impossible_move (step 1), outside_gate, not_nearest (step 2), too_late, before_log,
  // arrived_before_capture, not_finite. "recovered" with accepted: the estimate was moved to it.
  std::string reason;
};

// Online: give samples and packets as they come, ask for the state at any time. In robust mode a packet is taken in at
// its capture time and all that came after is run again, so that the estimate depends on what arrived, not on the order
// in which it did. Local ENU throughout. Cost: of a sample, one step; of a packet, one step a sample since its capture.
class PoseFilter {
 public:
  // Throws invalid_argument where an option is out of range.
  explicit PoseFilter(PoseFilterOptions options);

  // Position is used for the first sample and, in paper mode, to tell false vehicles apart; velocity and attitude drive
  // the filter. False, and the sample is not used, where it is not later than the one before or is not finite.
  bool inertial(const survey::VehicleState& sample);
  void packet(const survey::ReceivedPacket& received);

  [[nodiscard]] bool started() const { return !nodes_.empty(); }
  // At the last sample. Throws failed_precondition before the first.
  [[nodiscard]] survey::VehicleState state() const;
  // At a time within the buffer or after the last sample (then on with its velocity). Times before the buffer give its
  // oldest state.
  [[nodiscard]] survey::VehicleState at(std::int64_t time_ns) const;
  // The full estimate at the last sample.
  [[nodiscard]] const PoseEstimate& estimate() const;

  // One entry a projected position so far, by packet then candidate. Entries of the last buffer_s may still change.
  [[nodiscard]] const std::vector<PoseUpdate>& updates() const { return updates_; }

 private:
  struct Node {  // a sample of the log, and the estimate with all that counts for times up to it
    survey::VehicleState sample;
    PoseEstimate estimate;
  };
  struct Measurement {         // a packet
    std::int64_t time_ns = 0;  // at which it counts
    std::size_t packet = 0;
    std::size_t first_update = 0, update_count = 0;  // in updates_
    std::vector<geometry::Mat2> covariances;
  };

  void advance(std::size_t from_node);
  void step(PoseEstimate& estimate, const survey::VehicleState& from, const survey::VehicleState& to,
            std::int64_t begin_ns, std::int64_t end_ns) const;
  void take(PoseEstimate& estimate, const Measurement& measurement, const survey::VehicleState& sample);
  void forget();
  [[nodiscard]] survey::VehicleState described(const PoseEstimate& estimate, const survey::VehicleState& from,
                                               const survey::VehicleState& to, std::int64_t time_ns) const;

  PoseFilterOptions options_;
  std::deque<Node> nodes_;
  std::deque<Measurement> measurements_;  // ascending time, then packet; those of the buffer and those not yet reached
  std::vector<PoseUpdate> updates_;
  std::size_t packets_ = 0;
  bool forgot_ = false;  // whether the oldest node is no longer the first sample
};

// NEES: squared error over covariance, 2 on average where the covariance is right.
[[nodiscard]] double position_nees(const survey::VehicleState& estimate, const geometry::Vec2& truth);

}  // namespace cairn::ground
