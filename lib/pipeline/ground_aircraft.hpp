// The aircraft of a closed loop: what it sees at each exposure, and what it sends.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ground/frame_packet.hpp"
#include "simulation/drive_rehearsal.hpp"

namespace cairn::pipeline {

struct AircraftOptions {
  ground::ClassTable classes;
  ground::ProjectionOptions projection;
};

class GroundAircraft {
 public:
  GroundAircraft(const simulation::DriveRehearsal& rehearsal, const AircraftOptions& options, std::uint64_t seed);

  // Time of the next exposure, s after the first; +infinity after the last.
  [[nodiscard]] double next_s() const;
  // Takes the next exposure with the vehicle at `pose`; returns the packet made of its detections.
  survey::Packet expose(const simulation::DriveRehearsal::Pose& pose);

  // What was recorded so far, the vehicle as last object of the truth (its cylinder where it was first seen).
  [[nodiscard]] simulation::Recording recording() &&;

 private:
  void take(const survey::Detection& detection, survey::ObjectId object, std::int64_t clutter);

  const simulation::DriveRehearsal& rehearsal_;
  AircraftOptions options_;
  std::uint64_t seed_;
  simulation::Recording all_;   // without the vehicle, to the end of the flight
  simulation::Recording kept_;  // tables up to now, with the vehicle
  survey::ObjectId vehicle_;
  std::size_t frame_ = 0, detection_ = 0, box_ = 0;  // next of all_
};

}  // namespace cairn::pipeline
