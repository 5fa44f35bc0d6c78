// cairn route COSTMAP --from LAT,LON --to LAT,LON -o OUT
#include "base/number_text.hpp"
#include "pipeline/route_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

class RouteCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("costmap", costmap_, "costmap.tif of 'cairn costmap'");
    arguments.output(out_, "Folder of the result");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn route cost/costmap.tif --from 46.84262,-91.99401 --to 46.84281,-91.99355 -o route");
    arguments.example("cairn route cost/costmap.tif --from-local -10,5 --to-local 40,20 -o route --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "route");
    const auto inputs = pipeline::digest_inputs({costmap_});
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"route", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) { return pipeline::route_stage(costmap_, staged, options_, ctx); },
        ctx);
    return {outcome.summary, "Route of " + base::to_fixed(outcome.summary.at("length_m").as_real(), 1) +
                                 " m, clearance " + base::to_fixed(outcome.summary.at("clearance_m").as_real(), 2) +
                                 " m, in " + out_.string() + "\n"};
  }

 private:
  std::filesystem::path costmap_, out_;
  pipeline::RouteStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::RouteCommand)
