#include "pipeline/vehicle_stage.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "ground/pose_run.hpp"
#include "ground/pose_score.hpp"
#include "io/csv.hpp"
#include "io/packets.hpp"
#include "io/vehicle_csv.hpp"
#include "pipeline/function_stage.hpp"
#include "pipeline/vehicle_plot.hpp"
#include "pipeline/vehicle_recording.hpp"

namespace cairn::pipeline {
namespace fs = std::filesystem;
namespace {

using geometry::Vec2;
using io::Json;
using survey::VehicleState;

// Reasons of positions that are no vehicle, or not the one: found by the filter as it should.
constexpr std::array kFalse{"impossible_move", "outside_gate", "not_nearest", "after_log", "before_log", "too_late"};

void write_comparison(const fs::path& path, const ground::PoseRun& run, std::span<const VehicleState> truth) {
  io::CsvWriter csv(path, {"time_ns", "filter_x_m", "filter_y_m", "log_x_m", "log_y_m", "dead_reckoned_x_m",
                           "dead_reckoned_y_m", "projected_x_m", "projected_y_m", "truth_x_m", "truth_y_m"});
  const auto cells = [&](const std::optional<Vec2>& p) {
    csv.cell(p ? std::optional(p->x()) : std::nullopt).cell(p ? std::optional(p->y()) : std::nullopt);
  };
  for (std::size_t i = 0; i < run.filtered.size(); ++i) {
    csv.cell(run.filtered[i].time_ns);
    cells(run.filtered[i].position);
    cells(run.inertial[i].position);
    cells(run.dead_reckoned[i].position);
    cells(run.projected[i]);
    cells(ground::position_at(truth, run.filtered[i].time_ns));
    csv.end_row();
  }
  csv.finish();
}

void write_residuals(const fs::path& path, const std::vector<ground::PoseUpdate>& updates) {
  io::CsvWriter csv(path, {"packet", "sequence", "candidate", "capture_time_ns", "arrival_time_ns", "x_m", "y_m",
                           "residual_x_m", "residual_y_m", "gate_sigma", "taken", "reason"});
  for (const auto& u : updates) {
    csv.cell(static_cast<std::uint64_t>(u.packet)).cell(static_cast<std::int64_t>(u.sequence)).cell(u.candidate);
    csv.cell(u.capture_time_ns).cell(u.arrival_time_ns).cell(u.position.x()).cell(u.position.y());
    csv.cell(u.residual.x()).cell(u.residual.y()).cell(u.gate).cell(u.accepted ? "yes" : "no").cell(u.reason);
    csv.end_row();
  }
  csv.finish();
}

Json to_json(const ground::TrackErrors& e) {
  return Json::object(
      {{"states", e.count}, {"rms_m", e.rms_m}, {"median_m", e.median_m}, {"p95_m", e.p95_m}, {"max_m", e.max_m}});
}

Json errors_of(const ground::PoseRun& run, const VehicleRecording& recording) {
  if (recording.truth.empty()) return {};
  std::vector<VehicleState> projected;
  for (std::size_t i = 0; i < run.projected.size(); ++i)
    if (run.projected[i]) {
      projected.emplace_back();
      projected.back().time_ns = run.filtered[i].time_ns;
      projected.back().position = *run.projected[i];
    }
  std::vector<std::int64_t> arrivals;
  for (const auto& p : recording.packets) arrivals.push_back(p.arrival_time_ns);
  constexpr double kDropout_s = 1.0;
  const auto filter = ground::track_errors(run.filtered, recording.truth);
  const auto dropouts = ground::dropout_errors(run.filtered, recording.truth, arrivals, kDropout_s);
  Json of_filter = to_json(filter);
  of_filter.set("nees", filter.nees);
  return Json::object({{"filter", of_filter},
                       {"log_alone", to_json(ground::track_errors(run.inertial, recording.truth))},
                       {"dead_reckoned", to_json(ground::track_errors(run.dead_reckoned, recording.truth))},
                       {"projected_alone", to_json(ground::track_errors(projected, recording.truth))},
                       {"dropouts", Json::object({{"least_s", kDropout_s},
                                                  {"count", dropouts.count},
                                                  {"longest_s", dropouts.longest_s},
                                                  {"distance_m", dropouts.distance_m},
                                                  {"growth_percent", dropouts.growth_percent},
                                                  {"drift_percent", dropouts.drift_percent}})}});
}

struct Gaps {
  std::size_t count = 0;
  double longest_s = 0.0;
};

Gaps gaps_of(std::span<const VehicleState> log, double longest_allowed_s) {
  Gaps gaps;
  for (std::size_t i = 1; i < log.size(); ++i) {
    const double s = static_cast<double>(log[i].time_ns - log[i - 1].time_ns) * 1e-9;
    if (s <= longest_allowed_s) continue;
    ++gaps.count;
    gaps.longest_s = std::max(gaps.longest_s, s);
  }
  return gaps;
}

Json positions_summary(const std::vector<ground::PoseUpdate>& updates) {
  std::size_t taken = 0, recovered = 0;
  double squares = 0.0;
  std::map<std::string, std::size_t> refused;
  for (const auto& u : updates) {
    if (!u.accepted) {
      ++refused[u.reason];
      continue;
    }
    ++taken;
    recovered += u.reason == "recovered" ? 1U : 0U;
    squares += u.residual.squaredNorm();
  }
  Json by_reason = Json::object();
  for (const auto& [reason, count] : refused) by_reason.set(reason, count);
  return Json::object({{"count", updates.size()},
                       {"taken", taken},
                       {"recovered", recovered},
                       {"residual_rms_m", taken > 0 ? std::sqrt(squares / static_cast<double>(taken)) : 0.0},
                       {"refused_by_reason", by_reason}});
}

Json bandwidth_summary(const std::vector<survey::ReceivedPacket>& packets, const ground::BandwidthOptions& options) {
  Json rows = Json::object();
  for (const auto& row : ground::bandwidth(packets, options))
    rows.set(row.what, Json::object({{"bytes_each", row.bytes_each},
                                     {"bytes_per_s", row.bytes_per_s},
                                     {"times_packets", row.times_packets}}));
  return rows;
}

double way_of(std::span<const VehicleState> track) {
  double way = 0.0;
  for (std::size_t i = 1; i < track.size(); ++i) way += (track[i].position - track[i - 1].position).norm();
  return way;
}

std::vector<base::Reject> rejects_of(const VehicleRecording& recording,
                                     const std::vector<ground::PoseUpdate>& updates) {
  std::vector<base::Reject> rejects = recording.log.rejects;
  rejects.insert(rejects.end(), recording.packet_rejects.begin(), recording.packet_rejects.end());
  for (const auto& u : updates) {
    if (u.accepted) continue;
    const std::string record = "packet " + std::to_string(u.sequence) + " vehicle " + std::to_string(u.candidate);
    rejects.push_back({record, u.reason,
                       record + ": not taken, " + base::to_fixed(u.residual.norm(), 2) + " m (" +
                           base::to_fixed(u.gate, 1) + " sigma) from the prediction"});
  }
  return rejects;
}

}  // namespace

bool is_recording_fault(const base::Reject& reject) {
  return std::none_of(kFalse.begin(), kFalse.end(), [&](const char* reason) { return reject.reason == reason; });
}

Outcome vehicle_stage(const VehicleInputs& in, const fs::path& out, const VehicleStageOptions& options,
                      base::RunContext& ctx) {
  VehicleStageOptions used = options;
  base::validate(base::bind_options(used), "vehicle");
  const auto recording = read_vehicle_recording(in, used, ctx);
  const auto& log = recording.log.samples;
  const double interval_s = ground::median_interval_s(log);
  if (!(used.filter.sample_interval_s > 0.0) && interval_s > 0.0)
    used.filter.sample_interval_s = std::min(interval_s, 1e3);
  constexpr double kGapIntervals = 10.0;
  if (!(used.filter.max_gap_s > 0.0)) used.filter.max_gap_s = kGapIntervals * used.filter.sample_interval_s;
  const Gaps gaps = gaps_of(log, used.filter.max_gap_s);
  if (gaps.count > 0)
    ctx.warn("The log has " + std::to_string(gaps.count) + " gaps, the longest of " +
             base::to_fixed(gaps.longest_s, 2) +
             " s: the velocity in them is taken between its ends, with a larger variance");
  if (recording.packets.empty()) ctx.warn("No packets: the track is the log's velocities summed");

  const double duration_s = static_cast<double>(log.back().time_ns - log.front().time_ns) * 1e-9;
  constexpr std::uint64_t kBytesState = 600;
  ctx.check_memory(static_cast<std::uint64_t>(duration_s * used.rate_hz) * kBytesState, "states of the track");
  const auto run = ground::run_pose_filter(log, recording.packets, used.filter, used.rate_hz, ctx);

  io::write_vehicle_csv(out / "vehicle.csv", run.filtered);
  write_comparison(out / "comparison.csv", run, recording.truth);
  write_residuals(out / "residuals.csv", run.updates);
  if (used.replay) io::write_packets(out / "packets_replayed.bin", recording.packets);
  if (used.plot)
    base::write_file(out / "vehicle.svg", vehicle_plot(run.filtered, run.inertial, recording.truth, run.updates));

  Outcome outcome;
  outcome.rejects = rejects_of(recording, run.updates);
  const auto periods = ground::update_periods(recording.packets);
  double sigma = 0.0;
  for (const auto& s : run.filtered) sigma += s.covariance ? std::sqrt(0.5 * s.covariance->trace()) : 0.0;
  Json packets = Json::object({{"source", recording.packet_source},
                               {"count", recording.packets.size()},
                               {"broken", recording.packet_rejects.size()},
                               {"mean_period_s", periods.mean_s},
                               {"median_period_s", periods.median_s},
                               {"max_period_s", periods.max_s},
                               {"mean_age_s", periods.mean_age_s},
                               {"max_age_s", periods.max_age_s}});
  if (used.replay)
    packets.set("replay", Json::object({{"sent", recording.link.sent},
                                        {"delivered", recording.link.delivered},
                                        {"lost", recording.link.lost},
                                        {"replaced", recording.link.replaced},
                                        {"bytes", recording.link.bytes}}));
  outcome.summary = Json::object({{"mode", used.filter.mode},
                                  {"states", run.filtered.size()},
                                  {"rate_hz", used.rate_hz},
                                  {"duration_s", duration_s},
                                  {"distance_m", way_of(run.filtered)},
                                  {"mean_sigma_m", sigma / static_cast<double>(run.filtered.size())},
                                  {"log", Json::object({{"format", recording.log.format},
                                                        {"convention", recording.log.convention},
                                                        {"samples", log.size()},
                                                        {"interval_s", interval_s},
                                                        {"gaps", gaps.count},
                                                        {"longest_gap_s", gaps.longest_s}})},
                                  {"packets", packets},
                                  {"positions", positions_summary(run.updates)},
                                  {"bandwidth", bandwidth_summary(recording.packets, used.bandwidth)},
                                  {"errors", errors_of(run, recording)},
                                  {"rejects_by_reason", count_by_reason(outcome.rejects)}});
  base::write_file(out / "vehicle.json", outcome.summary.dump() + "\n");
  return outcome;
}

std::unique_ptr<Stage> make_vehicle_stage() {
  return make_function_stage<VehicleStageOptions>(
      {"vehicle",
       {},
       {"obstacles"},
       [](const StageInputs&, const VehicleStageOptions&) -> Estimate {
         return {std::uint64_t{128} << 20U, std::uint64_t{32} << 20U};
       },
       [](const StageInputs& in, const fs::path& out, const VehicleStageOptions& options, base::RunContext& ctx) {
         VehicleInputs inputs;
         inputs.survey = in.survey;
         // Packets that the vehicle recorded stand before those made again from the images.
         const fs::path made = product(in, "obstacles", "packets.bin");
         if (!fs::exists(in.survey / "packets.bin") && !made.empty() && fs::exists(made)) inputs.packets = made;
         return vehicle_stage(inputs, out, options, ctx);
       },
       [](const StageInputs& in) -> std::string {
         return fs::exists(in.survey / "vehicle.csv") ? "" : "vehicle.csv";
       }});
}

}  // namespace cairn::pipeline
