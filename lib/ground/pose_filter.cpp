#include "ground/pose_filter.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "ground/false_vehicles.hpp"

namespace cairn::ground {
namespace {

using geometry::Mat2;
using geometry::Vec2;
using survey::VehicleState;

constexpr double kNanoseconds = 1e9;

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) / kNanoseconds;
}

// Velocity between two samples, linear; before and behind them, theirs.
Vec2 velocity_at(const VehicleState& from, const VehicleState& to, std::int64_t time_ns) {
  if (time_ns <= from.time_ns || to.time_ns == from.time_ns) return from.velocity;
  if (time_ns >= to.time_ns) return to.velocity;
  const double s = seconds(time_ns - from.time_ns) / seconds(to.time_ns - from.time_ns);
  return (1.0 - s) * from.velocity + s * to.velocity;
}

double turned_between(double from, double to, double s) {
  return std::remainder(from + s * std::remainder(to - from, 2.0 * std::numbers::pi), 2.0 * std::numbers::pi);
}

}  // namespace

void PoseFilterOptions::visit(base::OptionVisitor& v) {
  v.choice("mode", mode, {"paper", "robust"}, "paper: the published filter to the letter; robust: the corrected one");
  v.real("projector-sigma-m", projector_sigma_m, 1e-3, 100.0,
         "1 sigma per axis of a projected position where the packet gives none");
  v.real("min-projector-sigma-m", min_projector_sigma_m, 0.0, 100.0, "no projected position is better than this");
  v.real("max-speed-m-s", max_speed_m_s, 0.0, 1e3, "what the vehicle can do; faster detections are false");
  v.real("jump-margin-m", jump_margin_m, 0.0, 1e3, "added to the way at that speed: error of a projected position");
  v.real("gate-sigma", gate_sigma, 0.1, 100.0, "projected positions farther off than this are false");
  v.integer("recovery-packets", recovery_packets, 2, 1000000,
            "refused positions in a row that agree and so move the estimate");
  v.real("initial-sigma-m", initial_sigma_m, 1e-3, 1e6, "1 sigma per axis of the log's first position");
  v.real("velocity-noise-m-s", velocity_noise_m_s, 0.0, 100.0, "noise of the log's velocity, 1 sigma per sample");
  v.real("sample-interval-s", sample_interval_s, 0.0, 1e3,
         "interval of the samples that this noise belongs to; 0 = the log's");
  v.real("bias-sigma-m-s", bias_sigma_m_s, 0.0, 100.0, "drifting bias of the log's velocity, 1 sigma per axis");
  v.real("bias-time-s", bias_time_s, 1e-2, 1e9, "correlation time of that bias");
  v.real("heading-sigma-deg", heading_sigma_deg, 0.0, 180.0, "drifting heading error of the log, 1 sigma");
  v.real("heading-time-s", heading_time_s, 1e-2, 1e9, "correlation time of that error");
  v.real("paper-sigma-position-m", paper_sigma_position_m, 0.0, 100.0, "paper: w of (B.5), 1 sigma per step");
  v.real("paper-sigma-velocity-m-s", paper_sigma_velocity_m_s, 0.0, 100.0, "paper: w' of (B.6), 1 sigma per step");
  v.real("max-gap-s", max_gap_s, 0.0, 1e6, "longer intervals of the log count as gaps; 0 = 10 sample intervals");
  v.real("gap-sigma-m-s", gap_sigma_m_s, 0.0, 100.0, "1 sigma of the velocity in a gap");
  v.real("buffer-s", buffer_s, 0.0, 3600.0, "how late a packet may come");
}

PoseFilter::PoseFilter(PoseFilterOptions options) : options_(std::move(options)) {
  constexpr double kUsualInterval_s = 0.02, kGapIntervals = 10.0;
  base::validate(base::bind_options(options_), "vehicle");
  if (!(options_.sample_interval_s > 0.0)) options_.sample_interval_s = kUsualInterval_s;
  if (!(options_.max_gap_s > 0.0)) options_.max_gap_s = kGapIntervals * options_.sample_interval_s;
}

bool PoseFilter::inertial(const VehicleState& sample) {
  const bool finite = sample.position.allFinite() && sample.velocity.allFinite() && std::isfinite(sample.roll) &&
                      std::isfinite(sample.pitch) && std::isfinite(sample.yaw) &&
                      (!sample.covariance || sample.covariance->allFinite());
  if (!finite || (!nodes_.empty() && sample.time_ns <= nodes_.back().sample.time_ns)) return false;
  if (nodes_.empty()) {
    Node first{sample, {}};
    auto& e = first.estimate;
    e.mean.head<2>() = sample.position;
    e.covariance.topLeftCorner<2, 2>() =
        sample.covariance.value_or(Mat2(options_.initial_sigma_m * options_.initial_sigma_m * Mat2::Identity()));
    if (options_.mode != "paper") {
      e.covariance.diagonal().segment<2>(2).setConstant(options_.bias_sigma_m_s * options_.bias_sigma_m_s);
      const double heading = options_.heading_sigma_deg * std::numbers::pi / 180.0;
      e.covariance(4, 4) = heading * heading;
    }
    e.accepted_ns = sample.time_ns;
    e.accepted_position = sample.position;
    nodes_.push_back(first);
  } else {
    nodes_.push_back({sample, {}});
    advance(nodes_.size() - 2);
  }
  forget();
  return true;
}

void PoseFilter::packet(const survey::ReceivedPacket& received) {
  const bool paper = options_.mode == "paper";
  const auto& packet = received.packet;
  Measurement m;
  m.time_ns = paper ? received.arrival_time_ns : packet.capture_time_ns;
  m.packet = packets_++;
  m.first_update = updates_.size();
  m.update_count = packet.vehicles.size();
  std::string reason;
  if (received.arrival_time_ns < packet.capture_time_ns) reason = "arrived_before_capture";
  else if (nodes_.empty()) reason = "before_log";
  else if (forgot_ && m.time_ns <= nodes_.front().sample.time_ns) reason = "too_late";
  else if (m.time_ns < nodes_.front().sample.time_ns) reason = "before_log";
  for (std::size_t i = 0; i < packet.vehicles.size(); ++i) {
    const auto& v = packet.vehicles[i];
    PoseUpdate u;
    u.packet = m.packet;
    u.sequence = packet.sequence;
    u.candidate = static_cast<int>(i);
    u.capture_time_ns = packet.capture_time_ns;
    u.arrival_time_ns = received.arrival_time_ns;
    u.position = v.position.head<2>();
    u.reason = reason;
    const bool finite = v.position.allFinite() && v.covariance.allFinite();
    if (reason.empty() && !finite) u.reason = "not_finite";
    if (!finite) u.position.setZero();
    const double sigma = options_.projector_sigma_m;
    Mat2 r = sigma * sigma * Mat2::Identity();
    if (!paper && finite && v.covariance(0, 0) > 0.0 && v.covariance(1, 1) > 0.0) {
      const double floor = options_.min_projector_sigma_m;
      r = 0.5 * (v.covariance + v.covariance.transpose());
      r.diagonal() = r.diagonal().cwiseMax(floor * floor);
    }
    m.covariances.push_back(r);
    updates_.push_back(std::move(u));
  }
  if (m.update_count == 0 || !reason.empty()) return;
  const auto place = std::upper_bound(measurements_.begin(), measurements_.end(), m,
                                      [](const Measurement& a, const Measurement& b) { return a.time_ns < b.time_ns; });
  const std::int64_t time_ns = m.time_ns;
  measurements_.insert(place, std::move(m));
  // The last sample before it; the estimates behind that one are run again.
  std::size_t from = nodes_.size() - 1;
  while (from > 0 && nodes_[from].sample.time_ns >= time_ns) --from;
  if (nodes_.back().sample.time_ns >= time_ns) advance(from);
}

void PoseFilter::step(PoseEstimate& estimate, const VehicleState& from, const VehicleState& to, std::int64_t begin_ns,
                      std::int64_t end_ns) const {
  const bool gap = seconds(to.time_ns - from.time_ns) > options_.max_gap_s;
  propagate(estimate, velocity_at(from, to, begin_ns), velocity_at(from, to, end_ns), seconds(end_ns - begin_ns), gap,
            options_);
}

void PoseFilter::advance(std::size_t from_node) {
  const bool paper = options_.mode == "paper";
  const auto earlier = [](const Measurement& m, std::int64_t time_ns) { return m.time_ns < time_ns; };
  for (std::size_t i = from_node; i + 1 < nodes_.size(); ++i) {
    const auto& from = nodes_[i].sample;
    const auto& to = nodes_[i + 1].sample;
    PoseEstimate estimate = nodes_[i].estimate;
    std::int64_t now = from.time_ns;
    // A position at the very first sample counts with those behind it.
    const std::int64_t begin = i == 0 && !forgot_ ? now : now + 1;
    auto m = std::lower_bound(measurements_.begin(), measurements_.end(), begin, earlier);
    // The paper's steps end at samples of the log.
    if (paper) step(estimate, from, to, now, to.time_ns);
    for (; m != measurements_.end() && m->time_ns <= to.time_ns; ++m) {
      if (!paper) step(estimate, from, to, now, m->time_ns);
      now = m->time_ns;
      take(estimate, *m, to.time_ns - now < now - from.time_ns ? to : from);
    }
    if (!paper) step(estimate, from, to, now, to.time_ns);
    nodes_[i + 1].estimate = estimate;
  }
}

// Gates that the vehicle has to move: a fixed place falls out of the gate about their mean after two.
constexpr double kComeAlong = 2.5;

void PoseFilter::take(PoseEstimate& e, const Measurement& m, const VehicleState& sample) {
  const std::span<PoseUpdate> candidates(updates_.data() + m.first_update, m.update_count);
  for (auto& c : candidates) {
    if (c.reason == "not_finite") continue;
    c.reason.clear();
    c.accepted = false;
  }
  const int chosen = choose_vehicle(candidates, m.covariances, e, sample.position, seconds(m.time_ns - e.accepted_ns),
                                    sample.velocity.norm(), options_);
  if (chosen >= 0) {
    update(e, candidates[static_cast<std::size_t>(chosen)].position, m.covariances[static_cast<std::size_t>(chosen)]);
    e.accepted_ns = m.time_ns;
    e.accepted_position = e.position();
    e.accepted_any = true;
    e.refused = 0;
    e.refused_offset.setZero();
    return;
  }
  if (options_.mode == "paper") return;
  // Refused positions that agree with one another are the vehicle, and the estimate is wrong.
  int nearest = -1;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    if (candidates[i].reason != "not_finite" &&
        (nearest < 0 || (candidates[i].residual - e.refused_offset).norm() <
                            (candidates[static_cast<std::size_t>(nearest)].residual - e.refused_offset).norm()))
      nearest = static_cast<int>(i);
  if (nearest < 0) return;
  auto& c = candidates[static_cast<std::size_t>(nearest)];
  const Mat2& r = m.covariances[static_cast<std::size_t>(nearest)];
  const double agree = options_.gate_sigma * std::sqrt(std::max(r(0, 0), r(1, 1)));
  if (e.refused > 0 && (c.residual - e.refused_offset).norm() > agree) e.refused = 0;
  if (e.refused == 0) e.refused_offset.setZero(), e.refused_from = e.position();
  ++e.refused;
  e.refused_offset += (c.residual - e.refused_offset) / e.refused;
  // From a standing vehicle a thing that stands looks the same: only what has come along for longer than that can be
  // told apart is the vehicle.
  if (e.refused < options_.recovery_packets || (e.position() - e.refused_from).norm() < kComeAlong * agree) return;
  e.mean.head<2>() += e.refused_offset;
  e.covariance.topRows<2>().setZero();
  e.covariance.leftCols<2>().setZero();
  e.covariance.topLeftCorner<2, 2>() = r;
  e.accepted_ns = m.time_ns;
  e.accepted_position = e.position();
  e.accepted_any = true;
  e.refused = 0;
  e.refused_offset.setZero();
  c.accepted = true;
  c.reason = "recovered";
}

// What is older than the buffer, and what it was judged by, cannot change any more.
void PoseFilter::forget() {
  const std::int64_t oldest =
      nodes_.back().sample.time_ns -
      (options_.mode == "paper" ? 0 : static_cast<std::int64_t>(options_.buffer_s * kNanoseconds));
  while (nodes_.size() > 2 && nodes_[1].sample.time_ns <= oldest) {
    nodes_.pop_front();
    forgot_ = true;
  }
  while (forgot_ && !measurements_.empty() && measurements_.front().time_ns <= nodes_.front().sample.time_ns)
    measurements_.pop_front();
}

VehicleState PoseFilter::described(const PoseEstimate& e, const VehicleState& from, const VehicleState& to,
                                   std::int64_t time_ns) const {
  VehicleState s;
  s.time_ns = time_ns;
  const double span = seconds(to.time_ns - from.time_ns);
  const double part = span > 0.0 ? std::clamp(seconds(time_ns - from.time_ns) / span, 0.0, 1.0) : 0.0;
  s.position = e.position();
  s.velocity = corrected_velocity(e, velocity_at(from, to, time_ns));
  s.roll = turned_between(from.roll, to.roll, part);
  s.pitch = turned_between(from.pitch, to.pitch, part);
  s.yaw = std::remainder(turned_between(from.yaw, to.yaw, part) - e.mean[4], 2.0 * std::numbers::pi);
  s.covariance = e.position_covariance();
  return s;
}

const PoseEstimate& PoseFilter::estimate() const {
  if (nodes_.empty())
    throw base::Error(base::ErrorCode::failed_precondition, "the pose filter has no inertial sample yet");
  return nodes_.back().estimate;
}

VehicleState PoseFilter::state() const {
  const auto& e = estimate();
  const auto& sample = nodes_.back().sample;
  return described(e, sample, sample, sample.time_ns);
}

VehicleState PoseFilter::at(std::int64_t time_ns) const {
  static_cast<void>(estimate());
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), time_ns,
                                      [](std::int64_t time, const Node& n) { return time < n.sample.time_ns; });
  if (after == nodes_.begin())
    return described(nodes_.front().estimate, nodes_.front().sample, nodes_.front().sample, time_ns);
  const Node& node = *std::prev(after);
  PoseEstimate e = node.estimate;
  const VehicleState& from = node.sample;
  // Behind the last sample the vehicle goes on; beyond the greatest interval that is a gap.
  VehicleState to = after == nodes_.end() ? from : after->sample;
  if (after == nodes_.end()) to.time_ns = time_ns;
  step(e, from, to, from.time_ns, time_ns);
  return described(e, from, to, time_ns);
}

double position_nees(const VehicleState& estimate, const Vec2& truth) {
  if (!estimate.covariance) return 0.0;
  const Vec2 error = estimate.position - truth;
  return error.dot(estimate.covariance->inverse() * error);
}

}  // namespace cairn::ground
