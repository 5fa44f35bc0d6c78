// cairn costmap --obstacles OBSTACLES --surface DSM -o OUT
#include "pipeline/costmap_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

class CostmapCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.option("obstacles", in_.obstacles, "obstacles.json of 'cairn obstacles'");
    arguments.option("surface", in_.surface, "surface model (GeoTIFF); cells without a height are unknown");
    arguments.output(out_, "Folder of the result");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn costmap --obstacles out/obstacles.json --surface out/surface.tif --radius-m 0.4 -o cost");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    if (in_.obstacles.empty() || in_.surface.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "--obstacles and --surface are needed")
          .hint("See 'cairn costmap --help'");
    base::validate(base::bind_options(options_), "costmap");
    const auto inputs = pipeline::digest_inputs({in_.obstacles, in_.surface});
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"costmap", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) { return pipeline::costmap_stage(in_, staged, options_, ctx); }, ctx);
    return {outcome.summary, "Costmap and ROS map in " + out_.string() + "\n"};
  }

 private:
  pipeline::CostmapInputs in_;
  std::filesystem::path out_;
  ground::CostmapOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::CostmapCommand)
