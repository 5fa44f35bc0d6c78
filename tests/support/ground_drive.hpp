// A ground vehicle's drive with what was recorded of it: its inertial log, and the positions at which an aircraft saw
// it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "base/random.hpp"
#include "ground/link.hpp"
#include "ground/pose_score.hpp"
#include "simulation/inertial_log.hpp"
#include "survey/ground_vehicle.hpp"
#include "survey/packet.hpp"

namespace cairn::testing {

struct DriveOptions {
  double duration_s = 1200.0;
  double speed_m_s = 1.0;          // where it moves; it stands for a tenth of the time
  bool resting = false;            // paper B, B12
  double projector_sigma_m = 0.5;  // per axis
  double false_share = 0.1;        // of the packets, 3 to 10 m off; half of them with the true vehicle beside
  simulation::InertialErrors errors;
  ground::LinkOptions link;
};

struct Drive {
  std::vector<survey::VehicleState> truth, log;  // 50 Hz
  std::vector<survey::ReceivedPacket> packets;   // by arrival
  std::vector<bool> has_false, has_true;         // per packet of `packets`: a false vehicle, the true one

  [[nodiscard]] geometry::Vec2 true_position(std::int64_t time_ns) const {
    return ground::position_at(truth, time_ns).value();
  }
};

// A smooth wander: speed and turn rate follow slow waves with phases of the seed.
inline std::vector<survey::VehicleState> wander(const DriveOptions& options, std::uint64_t seed) {
  constexpr std::int64_t kStep_ns = 20'000'000;
  base::Random random(seed, "drive", 0);
  const double phase_a = random.uniform(0, 6.28), phase_b = random.uniform(0, 6.28), phase_c = random.uniform(0, 6.28);
  std::vector<survey::VehicleState> truth;
  survey::VehicleState s;
  s.position = {random.uniform(-20, 20), random.uniform(-20, 20)};
  s.yaw = random.uniform(-3, 3);
  const auto count = static_cast<std::int64_t>(options.duration_s * 1e9) / kStep_ns;
  for (std::int64_t i = 0; i <= count; ++i) {
    const double t = static_cast<double>(i) * 0.02;
    s.time_ns = i * kStep_ns;
    // Stands in each trough of a slow wave, eases in and out.
    const double ease = std::clamp(6.0 * (std::sin(t / 19.0 + phase_a) + 0.95), 0.0, 1.0);
    const double speed = options.resting ? 0.0 : options.speed_m_s * ease;
    const double rate =
        options.resting ? 0.0 : 0.25 * std::sin(t / 11.0 + phase_b) + 0.15 * std::sin(t / 4.7 + phase_c);
    s.velocity = speed * geometry::Vec2(std::cos(s.yaw), std::sin(s.yaw));
    truth.push_back(s);
    s.position += s.velocity * 0.02;
    s.yaw = std::remainder(s.yaw + rate * 0.02, 2.0 * std::numbers::pi);
  }
  return truth;
}

// What would be recorded of a true drive, ascending times, 2 samples or more.
inline Drive record_drive(std::vector<survey::VehicleState> truth, const DriveOptions& options, std::uint64_t seed) {
  Drive drive;
  drive.truth = std::move(truth);
  drive.log = simulation::inertial_log(drive.truth, options.errors, base::Random(seed, "drive log", 0));
  constexpr std::int64_t kCapture_ns = 250'000'000;
  ground::Link link(options.link, seed);
  std::vector<bool> made_false, made_true;
  const auto deliver = [&](std::int64_t now_ns) {
    for (auto& received : link.receive(now_ns)) {
      drive.has_false.push_back(made_false[received.packet.sequence]);
      drive.has_true.push_back(made_true[received.packet.sequence]);
      drive.packets.push_back(std::move(received));
    }
  };
  const std::int64_t end_ns = drive.truth.back().time_ns;
  for (std::int64_t time_ns = drive.truth.front().time_ns + 100'000'000; time_ns < end_ns; time_ns += kCapture_ns) {
    const std::uint32_t sequence = static_cast<std::uint32_t>(made_false.size());
    base::Random random(seed, "drive projector", sequence);
    survey::Packet packet;
    packet.sequence = sequence;
    packet.capture_time_ns = time_ns;
    const geometry::Vec2 there = drive.true_position(time_ns);
    const bool wrong = random.uniform() < options.false_share, beside = random.uniform() < 0.5;
    const auto see = [&](const geometry::Vec2& p) {
      packet.vehicles.push_back(
          {{p.x(), p.y(), 0.0}, options.projector_sigma_m * options.projector_sigma_m * geometry::Mat2::Identity()});
    };
    if (wrong) {
      const double angle = random.uniform(0, 2.0 * std::numbers::pi), far_m = random.uniform(3.0, 10.0);
      see(there + far_m * geometry::Vec2(std::cos(angle), std::sin(angle)));
    }
    if (!wrong || beside) {
      const double east = options.projector_sigma_m * random.normal();
      see(there + geometry::Vec2(east, options.projector_sigma_m * random.normal()));
    }
    made_false.push_back(wrong);
    made_true.push_back(!wrong || beside);
    deliver(time_ns);
    link.send(packet, time_ns);
  }
  deliver(end_ns);
  return drive;
}

inline Drive make_drive(const DriveOptions& options, std::uint64_t seed) {
  return record_drive(wander(options, seed), options, seed);
}

}  // namespace cairn::testing
