// cairn simulate SCENE.json --seed N -o SURVEY
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "pipeline/run_record.hpp"
#include "pipeline/scene_json.hpp"
#include "pipeline/simulate_stage.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class SimulateCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("scene", scene_, "Scene description (JSON)");
    arguments.output(out_, "Survey folder");
    arguments.example("cairn simulate samples/scenes/experiment_2.json --seed 1 -o survey");
    arguments.example("cairn simulate samples/scenes/tiny.json --dry-run --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    try {
      return simulated(arguments, ctx);
    } catch (base::Error& error) {
      error.default_file(scene_.string());
      throw;
    }
  }

 private:
  CommandResult simulated(const Arguments& arguments, base::RunContext& ctx) const {
    const auto scene = pipeline::read_scene(scene_);
    if (arguments.common.dry_run) {
      io::Json plan = pipeline::simulate_plan(scene, ctx);
      plan.set("would_write", out_.string());
      const std::string text = text_of(plan);
      return {std::move(plan), text};
    }
    const auto inputs = pipeline::digest_inputs(pipeline::scene_files(scene_));
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"simulate", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) { return pipeline::simulate_stage(scene, staged, ctx); }, ctx);
    return {outcome.summary, text_of(outcome.summary) + "Survey in " + out_.string() + "\n"};
  }

  static std::string text_of(const io::Json& summary) {
    const auto count = [&](const char* name) { return std::to_string(summary.at(name).as_integer()); };
    return count("frames") + " frames in " + base::to_fixed(summary.at("duration_s").as_real(), 0) + " s, " +
           count("objects") + " objects (" + count("sought") + " sought), " + count("true_boxes") + " true boxes\n";
  }

  fs::path scene_, out_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::SimulateCommand)
