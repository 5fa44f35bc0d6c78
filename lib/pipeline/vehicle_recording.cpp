#include "pipeline/vehicle_recording.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "io/json.hpp"
#include "io/packets.hpp"
#include "io/survey_json.hpp"
#include "io/vehicle_csv.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

struct Files {
  fs::path manifest, log, packets, truth;  // "" = there is none
};

Files files_of(const VehicleInputs& in) {
  Files files;
  files.packets = in.packets;
  files.truth = in.truth;
  if (!fs::is_directory(in.survey)) {
    files.log = in.survey;
    return files;
  }
  files.log = in.survey / "vehicle.csv";
  if (!fs::exists(files.log))
    throw base::Error(base::ErrorCode::not_found, "the survey has no vehicle.csv: no log of a ground vehicle")
        .file(in.survey.string())
        .hint("Put the vehicle's log there (docs/formats/vehicle.md), or give the log itself instead of the survey");
  if (fs::exists(in.survey / "survey.json")) files.manifest = in.survey / "survey.json";
  if (in.packets.empty() && in.positions.empty() && fs::exists(in.survey / "packets.bin"))
    files.packets = in.survey / "packets.bin";
  if (in.truth.empty() && fs::exists(in.survey / "truth/vehicle.csv")) files.truth = in.survey / "truth/vehicle.csv";
  return files;
}

std::optional<double> offset_of(const VehicleStageOptions& options) {
  if (options.packet_offset_s.empty()) return std::nullopt;
  constexpr double kLongest_s = 4e9;
  const auto value = base::parse_real(options.packet_offset_s);
  if (!value || !(std::abs(*value) < kLongest_s))
    throw base::Error(base::ErrorCode::invalid_argument, "--packet-offset-s is not a number of seconds")
        .found(options.packet_offset_s);
  return value;
}

// Positions seen from above, each as a packet that came at once.
std::vector<survey::ReceivedPacket> packets_of(const io::VehicleLog& positions) {
  std::vector<survey::ReceivedPacket> packets;
  for (const auto& s : positions.samples) {
    survey::ReceivedPacket received;
    received.arrival_time_ns = s.time_ns;
    received.packet.sequence = static_cast<std::uint32_t>(packets.size());
    received.packet.capture_time_ns = s.time_ns;
    survey::PacketVehicle vehicle;
    vehicle.position = {s.position.x(), s.position.y(), 0.0};
    if (s.covariance) vehicle.covariance = *s.covariance;
    received.packet.vehicles.push_back(vehicle);
    packets.push_back(std::move(received));
  }
  return packets;
}

std::string span_text(std::int64_t first_ns, std::int64_t last_ns) {
  return base::to_fixed(static_cast<double>(first_ns) * 1e-9, 3) + " to " +
         base::to_fixed(static_cast<double>(last_ns) * 1e-9, 3) + " s";
}

void require_overlap(const VehicleRecording& recording, const fs::path& file) {
  const auto& packets = recording.packets;
  if (packets.empty()) return;
  const auto [first, last] = std::minmax_element(packets.begin(), packets.end(), [](const auto& a, const auto& b) {
    return a.packet.capture_time_ns < b.packet.capture_time_ns;
  });
  const auto& log = recording.log.samples;
  if (first->packet.capture_time_ns > log.back().time_ns || last->packet.capture_time_ns < log.front().time_ns)
    throw base::Error(base::ErrorCode::failed_precondition,
                      "packets and log have no time in common: they were recorded on two clocks, or on two drives")
        .file(file.string())
        .found(span_text(first->packet.capture_time_ns, last->packet.capture_time_ns))
        .allowed("times within the log, " + span_text(log.front().time_ns, log.back().time_ns))
        .hint("Give --packet-offset-s, the seconds to add to the packets' times");
}

}  // namespace

std::vector<fs::path> vehicle_input_files(const VehicleInputs& in) {
  const Files files = files_of(in);
  std::vector<fs::path> named;
  for (const auto& file : {files.manifest, files.log, files.packets, in.positions, files.truth})
    if (!file.empty()) named.push_back(file);
  return named;
}

VehicleRecording read_vehicle_recording(const VehicleInputs& in, const VehicleStageOptions& options,
                                        base::RunContext& ctx) {
  if (!in.packets.empty() && !in.positions.empty())
    throw base::Error(base::ErrorCode::invalid_argument, "--packets and --positions exclude one another");
  const Files files = files_of(in);
  std::optional<survey::Manifest> manifest;
  if (!files.manifest.empty())
    manifest = io::manifest_from_json(io::read_json(files.manifest), files.manifest.string());
  std::optional<geometry::Geodetic> origin;
  if (manifest) origin = manifest->origin.position;

  VehicleRecording recording;
  recording.log = io::read_vehicle_log(files.log, in.format, origin);
  const auto offset = offset_of(options);
  recording.packet_source = "none";
  fs::path source;
  if (!files.packets.empty()) {
    source = files.packets;
    recording.packet_source = "packets";
    auto packets = io::read_packet_log(files.packets);
    const auto base = manifest ? manifest->time_base : base::TimeBase::unknown;
    if (!offset && base != packets.time_base && base != base::TimeBase::unknown &&
        packets.time_base != base::TimeBase::unknown)
      throw base::Error(base::ErrorCode::failed_precondition, "packets and log are on different time bases")
          .file(files.packets.string())
          .found(std::string(base::name_of(packets.time_base)))
          .allowed("the survey's: " + std::string(base::name_of(base)))
          .hint("Give --packet-offset-s, the seconds to add to the packets' times");
    recording.packets = std::move(packets.packets);
    recording.packet_rejects = std::move(packets.rejects);
  } else if (!in.positions.empty()) {
    source = in.positions;
    recording.packet_source = "positions";
    const auto positions = io::read_vehicle_log(in.positions, "auto", origin ? origin : recording.log.origin);
    if (positions.origin.has_value() != recording.log.origin.has_value() && !manifest)
      ctx.warn("Log and positions: one is in degrees, the other in metres; their origins may differ");
    recording.packets = packets_of(positions);
    recording.packet_rejects = positions.rejects;
  }
  if (offset)
    for (auto& p : recording.packets) {
      const auto shift = static_cast<std::int64_t>(std::llround(*offset * 1e9));
      p.arrival_time_ns += shift;
      p.packet.capture_time_ns += shift;
    }
  require_overlap(recording, source);
  if (options.replay) recording.packets = ground::replay(recording.packets, options.link, ctx.seed, &recording.link);
  std::stable_sort(recording.packets.begin(), recording.packets.end(),
                   [](const auto& a, const auto& b) { return a.arrival_time_ns < b.arrival_time_ns; });
  if (!files.truth.empty()) {
    recording.truth = io::read_vehicle_csv(files.truth);
    const auto& log = recording.log.samples;
    if (recording.truth.empty() || recording.truth.front().time_ns > log.back().time_ns ||
        recording.truth.back().time_ns < log.front().time_ns)
      throw base::Error(base::ErrorCode::failed_precondition, "truth and log have no time in common")
          .file(files.truth.string())
          .hint("Give the truth of this drive, on the same clock");
  }
  return recording;
}

}  // namespace cairn::pipeline
