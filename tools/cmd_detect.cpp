// cairn detect SURVEY --model M.onnx -o detections.csv
#include "io/survey_folder.hpp"
#include "pipeline/detect_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class DetectCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("survey", in_.survey, "Survey folder whose frames have images");
    arguments.output(out_, "detections.csv to write");
    arguments.option("model", in_.model, "Detector, ONNX");
    arguments.option("names", in_.names, "Class names, one a line; default: the model's own");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn detect survey --model boulders.onnx -o survey/detections.csv");
    arguments.example("cairn detect survey --model yolov8n.onnx --names coco.names --tile-px 1280 -o detections.csv");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    if (in_.model.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "no detector").hint("Name an ONNX model with --model");
    base::validate(base::bind_options(options_), "detect");
    std::vector<fs::path> named{in_.survey / "survey.json", in_.survey / "frames.csv", in_.model};
    if (!in_.names.empty()) named.push_back(in_.names);
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) {
      const auto survey = io::read_survey(in_.survey);
      return {io::Json::object({{"would_write", out_.string()}, {"frames", survey.frames.size()}}),
              "Would write " + out_.string() + " from " + std::to_string(survey.frames.size()) + " frames\n"};
    }
    const auto outcome = pipeline::run_to_file(
        out_, arguments.common.overwrite, {"detect", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) { return pipeline::detect_stage(in_, staged, options_, ctx); }, ctx);
    const auto count = [&](const char* name) { return std::to_string(outcome.summary.at(name).as_integer()); };
    return {outcome.summary,
            count("detections") + " detections in " + count("images") + " of " + count("frames") + " frames (" +
                outcome.summary.at("decoder").as_string() + ", " + count("tiles") + " looks)\nResult in " +
                out_.string() + "\n",
            outcome.rejects.empty() ? base::ExitCode::ok : base::ExitCode::item_failures};
  }

 private:
  pipeline::DetectInputs in_;
  fs::path out_;
  detection::DetectOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::DetectCommand)
