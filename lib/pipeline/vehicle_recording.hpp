// What stage `vehicle` reads, on one clock.
#pragma once

#include <string>
#include <vector>

#include "io/vehicle_log.hpp"
#include "pipeline/vehicle_stage.hpp"
#include "survey/packet.hpp"

namespace cairn::pipeline {

struct VehicleRecording {
  io::VehicleLog log;
  std::vector<survey::ReceivedPacket> packets;  // ascending arrival, on the log's clock
  std::vector<base::Reject> packet_rejects;
  std::string packet_source;                // "packets", "positions" or "none"
  std::vector<survey::VehicleState> truth;  // empty = not known
  ground::LinkCounts link;                  // with replay
};

[[nodiscard]] VehicleRecording read_vehicle_recording(const VehicleInputs& in, const VehicleStageOptions& options,
                                                      base::RunContext& ctx);

// The files that it reads.
[[nodiscard]] std::vector<std::filesystem::path> vehicle_input_files(const VehicleInputs& in);

}  // namespace cairn::pipeline
