// cairn route COSTMAP --from LAT,LON --to LAT,LON -o OUT; cairn route MAP.map --scenario FILE.scen
#include "base/number_text.hpp"
#include "pipeline/route_stage.hpp"
#include "pipeline/run_record.hpp"
#include "pipeline/scenario_stage.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

class RouteCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("costmap", costmap_, "costmap.tif of 'cairn costmap', or a .map of the Moving AI benchmarks");
    arguments.output(out_, "Folder of the result; with --scenario, a CSV of all queries", false);
    arguments.option("scenario", scenario_, "answer the queries of a Moving AI .scen over a .map, and compare");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn route cost/costmap.tif --from 46.84262,-91.99401 --to 46.84281,-91.99355 -o route");
    arguments.example("cairn route cost/costmap.tif --from-local -10,5 --to-local 40,20 -o route --json");
    arguments.example(
        "cairn route cost/costmap.tif --from-local 0,0 --to-local 40,20 --drive --packets survey/packets.bin -o route");
    arguments.example("cairn route arena.map --scenario arena.map.scen --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "route");
    if (!scenario_.empty()) return compare(arguments, ctx);
    if (out_.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "-o is needed").hint("Give the folder of the result");
    if (costmap_.extension() == ".map")
      throw base::Error(base::ErrorCode::invalid_argument, "a .map needs --scenario").file(costmap_.string());
    std::vector<std::filesystem::path> files{costmap_};
    if (!options_.packets.empty()) files.emplace_back(options_.packets);
    if (!options_.hidden.empty()) files.emplace_back(options_.hidden);
    const auto inputs = pipeline::digest_inputs(files);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"route", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) { return pipeline::route_stage(costmap_, staged, options_, ctx); },
        ctx);
    CommandResult result;
    result.summary = outcome.summary;
    const auto figure = [](const io::Json& json, std::string_view name, int decimals) {
      return base::to_fixed(json.at(name).as_real(), decimals);
    };
    result.text = "Route of " + figure(result.summary, "length_m", 1) + " m, clearance " +
                  figure(result.summary, "clearance_m", 2) + " m, in " + out_.string() + "\n";
    if (options_.drive) {
      const io::Json& drive = result.summary.at("drive");
      const std::string status = drive.at("status").as_string();
      result.text += "Driven " + figure(drive, "length_m", 1) + " m in " + figure(drive, "time_s", 1) +
                     " s, clearance " + figure(drive, "clearance_m", 2) + " m: " + status + "\n";
      // What was driven is written; a goal that was not reached is said by the exit code.
      if (status != "arrived") result.exit_code = base::ExitCode::item_failures;
    }
    return result;
  }

 private:
  CommandResult compare(const Arguments& arguments, base::RunContext& ctx) {
    const auto inputs = pipeline::digest_inputs({costmap_, scenario_});
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    pipeline::Outcome outcome;
    if (out_.empty()) {
      outcome = pipeline::scenario_stage(costmap_, scenario_, {}, ctx);
    } else {
      outcome = pipeline::run_to_file(
          out_, arguments.common.overwrite, {"route", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
          [&](const std::filesystem::path& staged) {
            return pipeline::scenario_stage(costmap_, scenario_, staged, ctx);
          },
          ctx);
    }
    CommandResult result;
    result.summary = outcome.summary;
    result.text = std::to_string(outcome.summary.at("queries").as_integer()) + " queries, " +
                  std::to_string(outcome.summary.at("found").as_integer()) +
                  " found, largest relative difference from the published lengths " +
                  base::to_text(outcome.summary.at("largest_relative_difference").as_real()) + "\n";
    if (!outcome.rejects.empty()) result.exit_code = base::ExitCode::item_failures;
    return result;
  }

  std::filesystem::path costmap_, scenario_, out_;
  pipeline::RouteStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::RouteCommand)
