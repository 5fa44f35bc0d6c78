// cairn vehicle SURVEY|LOG [--packets packets.bin] [--mode paper|robust] -o OUT
#include <algorithm>

#include "base/number_text.hpp"
#include "io/vehicle_log.hpp"
#include "pipeline/run_record.hpp"
#include "pipeline/vehicle_recording.hpp"
#include "pipeline/vehicle_stage.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class VehicleCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("survey", in_.survey, "Survey folder with vehicle.csv, or a vehicle's log by itself");
    arguments.output(out_, "Folder of the result");
    arguments.option("packets", in_.packets, "packets.bin that the vehicle received; else the survey's");
    arguments.option("positions", in_.positions, "or: table of positions at which the vehicle was seen");
    arguments.option("truth", in_.truth, "vehicle.csv with the true track; else the survey's truth/vehicle.csv");
    arguments.choice("format", in_.format, io::vehicle_log_formats(), "format of the log");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn vehicle flight --packets obstacles/packets.bin -o vehicle --json");
    arguments.example("cairn vehicle Plaza1_DR.txt -o plaza");
    arguments.example("cairn vehicle flight --replay --link-profile park --mode paper -o vehicle_paper");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "vehicle");
    const auto inputs = pipeline::digest_inputs(pipeline::vehicle_input_files(in_));
    if (arguments.common.dry_run) {
      const auto recording = pipeline::read_vehicle_recording(in_, options_, ctx);
      return {io::Json::object({{"would_write", out_.string()},
                                {"samples", recording.log.samples.size()},
                                {"packets", recording.packets.size()}}),
              "Inputs can be read: " + std::to_string(recording.log.samples.size()) + " samples, " +
                  std::to_string(recording.packets.size()) + " packets\n"};
    }
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"vehicle", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) { return pipeline::vehicle_stage(in_, staged, options_, ctx); }, ctx);
    const bool faults = std::any_of(outcome.rejects.begin(), outcome.rejects.end(), pipeline::is_recording_fault);
    return {outcome.summary, text_of(outcome.summary), faults ? base::ExitCode::item_failures : base::ExitCode::ok};
  }

 private:
  [[nodiscard]] std::string text_of(const io::Json& summary) const {
    const auto& positions = summary.at("positions");
    std::string text = std::to_string(summary.at("states").as_integer()) + " states over " +
                       base::to_fixed(summary.at("duration_s").as_real(), 1) + " s; " +
                       std::to_string(positions.at("taken").as_integer()) + " of " +
                       std::to_string(positions.at("count").as_integer()) + " projected positions taken\n";
    if (const auto* filter = summary.at("errors").find("filter"))
      text += "RMS error " + base::to_fixed(filter->at("rms_m").as_real(), 3) + " m; the log alone " +
              base::to_fixed(summary.at("errors").at("log_alone").at("rms_m").as_real(), 3) + " m\n";
    return text + "Results in " + out_.string() + "\n";
  }

  pipeline::VehicleInputs in_;
  fs::path out_;
  pipeline::VehicleStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::VehicleCommand)
