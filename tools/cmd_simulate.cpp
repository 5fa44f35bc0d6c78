// cairn simulate SCENE.json --seed N [--drive [--no-aerial]] -o SURVEY
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "pipeline/drive_stage.hpp"
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
    arguments.flag("drive", drive_, "Let the scene's ground vehicle drive to its goal: paper B in closed loop");
    arguments.flag("no-aerial", no_aerial_, "With --drive: obstacles seen from the air are not mapped");
    arguments.flag("no-aerial-pose", no_aerial_pose_,
                   "With --drive: positions of the vehicle seen from the air neither");
    arguments.option("outage-s", run_.outage_s, "With --drive: length of each outage of the link, s; 0 = none");
    arguments.option("outage-period-s", run_.outage_period_s, "With --drive: one outage in each such time, s");
    arguments.choice("mode", run_.mode, {"robust", "paper"},
                     "With --drive: of projector, obstacle memory, pose filter");
    arguments.example("cairn simulate samples/scenes/park.json --drive --seed 1 -o survey --json");
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
    if ((no_aerial_ || no_aerial_pose_) && !drive_)
      throw base::Error(base::ErrorCode::invalid_argument, "--no-aerial goes with --drive")
          .hint("Add --drive, or leave it out");
    if (arguments.common.dry_run) {
      io::Json plan = pipeline::simulate_plan(scene, ctx);
      plan.set("would_write", out_.string());
      const std::string text = text_of(plan);
      return {std::move(plan), text};
    }
    const auto inputs = pipeline::digest_inputs(pipeline::scene_files(scene_));
    auto run = run_;
    run.aerial_map = !no_aerial_;
    run.aerial_pose = !no_aerial_pose_;
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"simulate", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) {
          return drive_ ? pipeline::drive_stage(scene, staged, run, ctx) : pipeline::simulate_stage(scene, staged, ctx);
        },
        ctx);
    const std::string text = drive_ ? drive_text(outcome.summary) : text_of(outcome.summary);
    return {outcome.summary, text + "Survey in " + out_.string() + "\n"};
  }

  static std::string drive_text(const io::Json& summary) {
    const auto real = [&](const char* name, int digits) { return base::to_fixed(summary.at(name).as_real(), digits); };
    return summary.at("status").as_string() + " after " + real("path_m", 1) + " m and " + real("drive_s", 1) + " s, " +
           std::to_string(summary.at("contacts").as_integer()) + " contacts, " +
           std::to_string(summary.at("replans").as_integer()) + " replans; updates every " +
           real("update_period_mean_s", 2) + " s, at most " + real("update_period_max_s", 2) + " s; pose off by " +
           real("pose_rms_m", 2) + " m (RMS)\n";
  }

  static std::string text_of(const io::Json& summary) {
    const auto count = [&](const char* name) { return std::to_string(summary.at(name).as_integer()); };
    return count("frames") + " frames in " + base::to_fixed(summary.at("duration_s").as_real(), 0) + " s, " +
           count("objects") + " objects (" + count("sought") + " sought), " + count("true_boxes") + " true boxes\n";
  }

  fs::path scene_, out_;
  bool drive_ = false, no_aerial_ = false, no_aerial_pose_ = false;
  pipeline::GroundRunOptions run_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::SimulateCommand)
