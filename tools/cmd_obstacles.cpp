// cairn obstacles SURVEY [--targets T.json] [--terrain DSM] [--mode paper|robust] -o OUT
#include "io/survey_folder.hpp"
#include "pipeline/locate_stage.hpp"
#include "pipeline/obstacles_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class ObstaclesCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("survey", in_.survey, "Survey folder");
    arguments.output(out_, "Folder of the result");
    arguments.option("targets", in_.targets,
                     "targets.json of 'cairn locate'; without it the objects are located first");
    arguments.option("terrain", in_.terrain, "surface.tif of this survey: where the ground is");
    arguments.options([this](base::OptionVisitor& v) {
      v.flag("locate", locate_, "locate objects in several images first, where no targets are given");
      options_.visit(v);
    });
    arguments.example("cairn obstacles survey --mode paper --ground-up-m 0 -o obstacles_paper");
    arguments.example("cairn obstacles survey --targets out/targets.json --terrain out/surface.tif -o obstacles");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "obstacles");
    std::vector<fs::path> named{in_.survey / "survey.json", in_.survey / "frames.csv"};
    if (fs::exists(in_.survey / "detections.csv")) named.push_back(in_.survey / "detections.csv");
    for (const auto& path : {in_.targets, in_.terrain})
      if (!path.empty()) named.push_back(path);
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"obstacles", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) {
          auto in = in_;
          if (in.targets.empty() && options_.projection.mode == "robust" && locate_) {
            static_cast<void>(pipeline::locate_stage({in_.survey, in_.terrain, {}}, staged, {}, ctx));
            in.targets = staged / "targets.json";
          }
          return pipeline::obstacles_stage(in, staged, options_, ctx, {true, true});
        },
        ctx);
    const auto count = [&](const char* name) { return std::to_string(outcome.summary.at(name).as_integer()); };
    return {outcome.summary, count("obstacle") + " obstacles, " + count("ignored") + " objects to pass below, " +
                                 count("vehicle") + " vehicles (" + count("located") + " located, " +
                                 count("projected") + " projected), in " + out_.string() + "\n"};
  }

 private:
  pipeline::ObstaclesInputs in_;
  fs::path out_;
  bool locate_ = true;
  pipeline::ObstaclesStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::ObstaclesCommand)
