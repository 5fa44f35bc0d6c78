// Stage `vehicle`: a ground vehicle's log and the packets it received -> its filtered track.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "base/run_context.hpp"
#include "ground/bandwidth.hpp"
#include "ground/link.hpp"
#include "ground/pose_filter.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct VehicleInputs {
  std::filesystem::path survey;     // survey folder with vehicle.csv, or a log by itself
  std::filesystem::path packets;    // packets.bin; "" = that of the survey folder, where it has one
  std::filesystem::path positions;  // or: a table of projected positions, each a packet with one vehicle
  std::filesystem::path truth;      // vehicle.csv; "" = truth/vehicle.csv of the survey folder, where it has one
  std::string format = "auto";      // of the log (io::vehicle_log_formats)
};

struct VehicleStageOptions {
  ground::PoseFilterOptions filter;
  double rate_hz = 25.0;        // of the track that is written (paper B: 20 or 25)
  std::string packet_offset_s;  // added to the packets' times, s; "" = 0, and the time bases must agree
  bool replay = false;          // send the packets once more, at their capture times, over the simulated link
  ground::LinkOptions link;
  ground::BandwidthOptions bandwidth;
  bool plot = true;

  void visit(base::OptionVisitor& visitor) {
    filter.visit(visitor);
    visitor.real("rate-hz", rate_hz, 0.1, 1000.0, "states of the written track in a second");
    visitor.text("packet-offset-s", packet_offset_s, "seconds added to the packets' times; joins logs of two clocks");
    visitor.flag("replay", replay, "send the packets once more, over a simulated link");
    link.visit(visitor);
    bandwidth.visit(visitor);
    visitor.flag("plot", plot, "draw the tracks and their errors to vehicle.svg");
  }
};

// Writes into `out`:
//   vehicle.csv     the filtered track at rate_hz, each state from what had arrived by then
//   comparison.csv  the same times: filter, the log by itself, its velocities summed, the last projected position,
//   truth residuals.csv   one row a projected position: residual, gate, whether it was taken, why not packets.bin with
//   replay: the packets as they arrived vehicle.json    the summary: counts, update periods, bandwidth, errors where
//   the truth is known vehicle.svg     where plot
// Rejects: rows of the log, packets that cannot be read, refused positions.
// Throws not_found where the survey has no vehicle.csv, failed_precondition where time bases differ without an offset
// or packets and log do not overlap in time.
Outcome vehicle_stage(const VehicleInputs& in, const std::filesystem::path& out, const VehicleStageOptions& options,
                      base::RunContext& ctx);

// Whether a reject says that something is wrong with the recording, not merely that a detection was false.
[[nodiscard]] bool is_recording_fault(const base::Reject& reject);

// The recipe's stage `vehicle`.
[[nodiscard]] std::unique_ptr<Stage> make_vehicle_stage();

}  // namespace cairn::pipeline
