#include "pipeline/ground_run.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "base/angle.hpp"
#include "ground/link.hpp"
#include "pipeline/ground_aircraft.hpp"
#include "pipeline/ground_vehicle_mind.hpp"
#include "simulation/inertial_log.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec2;

constexpr double kAfterArrival_s = 0.5;  // recorded beyond the goal
constexpr double kScansBefore_s = 1.0;   // the scanner runs from this long before the vehicle may go

std::int64_t clock_ns(double run_s) {
  return static_cast<std::int64_t>(std::llround((simulation::kFirstFrame_s + run_s) * 1e9));
}

// The vehicle as it is.
class TrueVehicle {
 public:
  TrueVehicle(const simulation::DriveSpec& drive, double slip_share, std::uint64_t seed)
      : slip_share_(slip_share), random_(seed, "ground run slip", 0) {
    pose_ = {drive.start, ground::wrapped(std::numbers::pi / 2 - base::deg_to_rad(drive.heading_deg))};
  }

  void step(const ground::DriveVelocity& command, double dt, const ground::SkidSteerOptions& limits) {
    wheels_ = ground::approach(wheels_, command, dt, limits);
    // First-order Gauss-Markov, stationary, time constant 1 s.
    const double keep = std::exp(-dt), fresh = slip_share_ * std::sqrt(1.0 - keep * keep);
    forward_slip_ = keep * forward_slip_ + fresh * random_.normal();
    turn_slip_ = keep * turn_slip_ + fresh * random_.normal();
    motion_ = {wheels_.forward_m_s * (1.0 + forward_slip_), wheels_.turn_rad_s * (1.0 + turn_slip_)};
    const Vec2 before = pose_.position;
    pose_ = ground::moved(pose_, motion_, dt);
    velocity_ = (pose_.position - before) / dt;
  }

  [[nodiscard]] const ground::PlanarPose& pose() const { return pose_; }
  [[nodiscard]] const ground::DriveVelocity& wheels() const { return wheels_; }  // as its odometry has it
  [[nodiscard]] const ground::DriveVelocity& motion() const { return motion_; }
  [[nodiscard]] const Vec2& velocity() const { return velocity_; }

 private:
  ground::PlanarPose pose_;
  ground::DriveVelocity wheels_, motion_;
  Vec2 velocity_ = Vec2::Zero();
  double slip_share_, forward_slip_ = 0.0, turn_slip_ = 0.0;
  base::Random random_;
};

struct SquareSum {
  double sum = 0.0, most = 0.0;
  std::size_t count = 0;
  void add(double error) {
    sum += error * error;
    most = std::max(most, error);
    ++count;
  }
  [[nodiscard]] double rms() const { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0; }
};

class GroundLoop {
 public:
  GroundLoop(const simulation::DriveRehearsal& rehearsal, const GroundRunOptions& options, std::uint64_t seed)
      : rehearsal_(rehearsal),
        drive_(rehearsal.drive()),
        options_(options),
        aircraft_(rehearsal, aircraft_options(), seed),
        link_(link_options(), base::Random(seed, "ground run link", 0).bits()),
        mind_(drive_, options),
        vehicle_(drive_, options.slip_share, seed),
        inertial_(inertial_errors(), base::Random(seed, "ground run inertial log", 0)),
        scan_random_(seed, "ground run scans", 0) {}

  GroundRecord run(base::RunContext& ctx) {
    const double dt = 1.0 / drive_.inertial.rate_hz;
    record_.start_s = simulation::kFirstFrame_s + drive_.start_s;
    record_.least_clearance_m = std::numeric_limits<double>::infinity();
    double end_s = drive_.limit_s;
    for (std::int64_t step = 0; static_cast<double>(step) * dt <= end_s; ++step) {
      ctx.check_stop();
      now_s_ = static_cast<double>(step) * dt;
      fly();
      listen();
      measure();
      if (due(next_tick_s_, 1.0 / mind_.rate_hz()) && now_s_ >= drive_.start_s) decide(ctx);
      if (record_.arrived && end_s == drive_.limit_s) end_s = now_s_ + kAfterArrival_s;
      move(dt);
    }
    return finished();
  }

 private:
  [[nodiscard]] AircraftOptions aircraft_options() const {
    AircraftOptions aircraft;
    aircraft.projection.mode = options_.mode;
    aircraft.projection.ground_up_m = rehearsal_.mean_up();
    return aircraft;
  }
  [[nodiscard]] ground::LinkOptions link_options() const {
    ground::LinkOptions link;
    link.profile = drive_.link;
    if (options_.outage_s > 0.0) {
      link.outage_s = options_.outage_s;
      link.outage_every_s = options_.outage_period_s;
    }
    return link;
  }
  [[nodiscard]] simulation::InertialErrors inertial_errors() const {
    simulation::InertialErrors errors;
    errors.velocity_noise_m_s = drive_.inertial.velocity_noise_m_s;
    errors.bias_sigma_m_s = drive_.inertial.velocity_bias_m_s;
    errors.heading_sigma_deg = drive_.inertial.heading_deg;
    return errors;
  }

  // True once every `period` from 0 on.
  bool due(double& next_s, double period) const {
    if (now_s_ + 1e-9 < next_s) return false;
    next_s += period;
    return true;
  }

  void fly() {
    while (aircraft_.next_s() <= now_s_ + 1e-9) {
      const auto packet = aircraft_.expose(rehearsal_.standing(vehicle_.pose().position, vehicle_.pose().yaw));
      if (options_.aerial_map || options_.aerial_pose) link_.send(packet, clock_ns(now_s_));
    }
  }

  void listen() {
    for (auto& received : link_.receive(clock_ns(now_s_))) {
      mind_.receive(received);
      record_.packets.push_back(std::move(received));
    }
  }

  void measure() {
    survey::VehicleState state;
    state.time_ns = clock_ns(now_s_);
    state.position = vehicle_.pose().position;
    state.velocity = vehicle_.velocity();
    state.yaw = vehicle_.pose().yaw;
    record_.truth.push_back(state);
    record_.inertial.push_back(inertial_.sample(state));
    mind_.inertial(record_.inertial.back());
    record_.filtered.push_back(mind_.state());
    if (now_s_ >= drive_.start_s) {
      pose_error_.add((record_.filtered.back().position - state.position).norm());
      inertial_error_.add((record_.inertial.back().position - state.position).norm());
    }
    if (!due(next_scan_s_, 1.0 / drive_.scanner.rate_hz) || now_s_ < drive_.start_s - kScansBefore_s) return;
    const auto standing = rehearsal_.standing(vehicle_.pose().position, vehicle_.pose().yaw);
    record_.scans.push_back(
        rehearsal_.scan(standing, vehicle_.velocity(), vehicle_.motion().turn_rad_s, state.time_ns, scan_random_));
    mind_.scan(record_.scans.back(), vehicle_.wheels());
  }

  void decide(base::RunContext& ctx) {
    const double left_before = way_left();
    const ground::DriveTick tick = mind_.tick(clock_ns(now_s_), vehicle_.wheels(), ctx);
    command_ = tick.command;
    record_.status = ground::name_of(tick.status);
    if (tick.replanned) {
      record_.plans.push_back({clock_ns(now_s_), tick.reason, mind_.driver().path()});
      if (record_.plans.size() == 1) keep("start");
      else if (way_left() > kSurprise * left_before) keep(tick.reason);
    }
    if (tick.status == ground::DriveStatus::arrived) {
      record_.arrived = true;
      command_ = {};
    }
  }

  // Of the path that is followed, from the vehicle on.
  [[nodiscard]] double way_left() const {
    const auto& path = mind_.driver().path();
    if (path.empty()) return 0.0;
    const Vec2 here = mind_.state().position;
    std::size_t nearest = 0;
    for (std::size_t i = 1; i < path.size(); ++i)
      if ((path[i] - here).squaredNorm() < (path[nearest] - here).squaredNorm()) nearest = i;
    double length = 0.0;
    for (std::size_t i = nearest + 1; i < path.size(); ++i) length += (path[i] - path[i - 1]).norm();
    return length;
  }

  void keep(const std::string& label) {
    if (record_.snapshots.size() < kMostSnapshots) record_.snapshots.push_back({clock_ns(now_s_), label, mind_.cost()});
  }

  void move(double dt) {
    const Vec2 before = vehicle_.pose().position;
    vehicle_.step(command_, dt, mind_.limits());
    record_.path_m += (vehicle_.pose().position - before).norm();
    const auto nearest = rehearsal_.contact().nearest(vehicle_.pose().position, vehicle_.pose().yaw);
    record_.least_clearance_m = std::min(record_.least_clearance_m, nearest.distance_m);
    const bool touching = nearest.distance_m == 0.0;
    if (touching && !touching_)
      record_.contacts.push_back({clock_ns(now_s_), rehearsal_.flown().objects()[nearest.object].truth.object_class,
                                  vehicle_.pose().position});
    touching_ = touching;
  }

  GroundRecord finished() {
    keep("end");
    record_.drive_s = now_s_ - drive_.start_s;
    record_.goal_error_m = (vehicle_.pose().position - drive_.goal).norm();
    record_.pose_rms_m = pose_error_.rms();
    record_.pose_max_m = pose_error_.most;
    record_.inertial_rms_m = inertial_error_.rms();
    record_.recoveries = mind_.driver().recoveries();
    record_.obstacles = mind_.obstacles();
    const std::int64_t start_ns = clock_ns(drive_.start_s);
    for (std::size_t i = 1; i < record_.packets.size(); ++i)
      if (record_.packets[i].arrival_time_ns >= start_ns)
        record_.update_periods_s.push_back(
            1e-9 * static_cast<double>(record_.packets[i].arrival_time_ns - record_.packets[i - 1].arrival_time_ns));
    record_.aerial = std::move(aircraft_).recording();
    return std::move(record_);
  }

  static constexpr double kSurprise = 1.15;  // a new way this much longer is worth a picture
  static constexpr std::size_t kMostSnapshots = 8;

  const simulation::DriveRehearsal& rehearsal_;
  const simulation::DriveSpec& drive_;
  const GroundRunOptions& options_;
  GroundAircraft aircraft_;
  ground::Link link_;
  VehicleMind mind_;
  TrueVehicle vehicle_;
  simulation::InertialLog inertial_;
  base::Random scan_random_;
  ground::DriveVelocity command_;
  GroundRecord record_;
  SquareSum pose_error_, inertial_error_;
  double now_s_ = 0.0, next_tick_s_ = 0.0, next_scan_s_ = 0.0;
  bool touching_ = false;
};

}  // namespace

void GroundRunOptions::visit(base::OptionVisitor& v) {
  v.flag("aerial-map", aerial_map, "the vehicle takes obstacles from the aircraft's packets");
  v.flag("aerial-pose", aerial_pose, "the vehicle takes its own positions from the aircraft's packets");
  v.real("outage-s", outage_s, 0.0, 3600.0, "length of each outage of the link; 0 = none");
  v.real("outage-period-s", outage_period_s, 0.1, 3600.0, "from the beginning of one outage to the next");
  v.real("slip-share", slip_share, 0.0, 0.5, "sigma of the share of speed and turn lost or won by slip");
  v.real("map-resolution-m", map_resolution_m, 0.02, 1.0, "edge of a cell of the vehicle's map");
  v.real("radius-m", radius_m, 0.05, 10.0, "radius of the vehicle, R of equation (9)");
  v.choice("mode", mode, {"robust", "paper"}, "paper = the letter of paper B");
}

GroundRecord run_ground(const simulation::DriveRehearsal& rehearsal, const GroundRunOptions& options,
                        std::uint64_t seed, base::RunContext& ctx) {
  GroundRunOptions checked = options;
  base::validate(base::bind_options(checked), "simulate --drive");
  return GroundLoop(rehearsal, checked, seed).run(ctx);
}

}  // namespace cairn::pipeline
