// cairn locate SURVEY [--mode paper|robust] -o OUT
#include "base/number_text.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/layers_stage.hpp"
#include "pipeline/locate_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class LocateCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("survey", in_.survey, "Survey folder with detections");
    arguments.output(out_, "Folder of the result");
    arguments.option("tracks", in_.tracks, "tracks.csv of 'cairn track': only registered boxes go on");
    arguments.option("terrain", in_.terrain, "surface.tif of this survey: bounds the depth of objects");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn locate samples/brighton_beach/survey -o located --json");
    arguments.example("cairn locate flight --tracks flight/tracks.csv -o located");
    arguments.example("cairn locate survey --mode paper --max-depth-m 18 -o located_paper");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    static_cast<void>(localisation::resolved(options_.locate));
    std::vector<fs::path> named{in_.survey / "survey.json", in_.survey / "frames.csv"};
    for (const auto* optional : {"detections.csv", "tie_points.csv"})
      if (fs::exists(in_.survey / optional)) named.push_back(in_.survey / optional);
    if (!in_.terrain.empty()) named.push_back(in_.terrain);
    if (!in_.tracks.empty()) named.push_back(in_.tracks);
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) {
      const auto survey = io::read_survey(in_.survey);
      return {io::Json::object({{"would_write", out_.string()},
                                {"frames", survey.frames.size()},
                                {"detections", survey.detections.size()}}),
              "Inputs can be read: " + std::to_string(survey.frames.size()) + " frames, " +
                  std::to_string(survey.detections.size()) + " detections\n"};
    }
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"locate", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) {
          auto located = pipeline::locate_stage(in_, staged, options_, ctx);
          write_layers(staged, ctx);
          return located;
        },
        ctx);
    return {outcome.summary, text_of(outcome.summary)};
  }

 private:
  // The targets, frames and footprints as layers; the inventory belongs to results with rocks.
  void write_layers(const fs::path& staged, base::RunContext& ctx) const {
    const fs::path folder = staged / "layers";
    fs::create_directory(folder);
    pipeline::LayersOptions layers;
    layers.kml = false;
    static_cast<void>(pipeline::layers_stage({in_.survey, staged / "targets.json", {}, {}, {}}, folder, layers, ctx));
    fs::rename(folder / "layers.gpkg", staged / "layers.gpkg");
    fs::remove_all(folder);
  }

  [[nodiscard]] std::string text_of(const io::Json& summary) const {
    const auto count = [&](const char* name) { return std::to_string(summary.at(name).as_integer()); };
    return count("converged") + " objects located, " + count("converging") + " still converging, " +
           count("generated") + " not located, " + count("deregistered") + " given up; " + count("used") + " of " +
           count("detections") + " detections used\nResults in " + out_.string() + "\n";
  }

  pipeline::LocateInputs in_;
  fs::path out_;
  pipeline::LocateStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::LocateCommand)
