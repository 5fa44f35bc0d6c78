// cairn segment CLOUD --targets targets.json [--survey SURVEY] -o LABELLED.las
#include "pipeline/run_record.hpp"
#include "pipeline/segment_stage.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

class SegmentCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("cloud", files_.cloud, "Point cloud: LAS, PLY, PCD, OBJ or XYZ");
    arguments.output(out_, "Labelled cloud: .las or .ply");
    arguments.option("targets", files_.targets, "targets.json: where the rocks are");
    arguments.option("survey", files_.survey, "Survey folder: where its cloud lies against its poses");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn segment model.las --targets out/targets.json --survey survey -o labelled.las --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "segment");
    if (files_.targets.empty())
      throw base::Error(base::ErrorCode::invalid_argument,
                        "segmentation is guided: it needs to know where the rocks are")
          .hint("Give --targets targets.json, as cairn locate writes it");
    std::vector<std::filesystem::path> named = {files_.cloud, files_.targets};
    if (!files_.survey.empty()) named.push_back(files_.survey / "survey.json");
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_file(
        out_, arguments.common.overwrite, {"segment", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) { return pipeline::segment_file(files_, staged, options_, ctx); },
        ctx);
    std::string text = std::to_string(outcome.summary.at("rocks").as_integer()) + " of " +
                       std::to_string(outcome.summary.at("targets").as_integer()) + " rocks cut, in " + out_.string() +
                       "\n";
    for (const auto& reject : outcome.rejects)
      text += "  " + reject.record + ": " + reject.reason + ", " + reject.message + "\n";
    return {outcome.summary, text};
  }

 private:
  pipeline::SegmentFiles files_;
  std::filesystem::path out_;
  pipeline::SegmentOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::SegmentCommand)
