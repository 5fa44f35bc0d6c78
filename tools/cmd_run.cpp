// cairn run RECIPE SURVEY -o OUT
#include <algorithm>

#include "base/number_text.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/executor.hpp"
#include "pipeline/recipe.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/survey_sources.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

std::string mebibytes(std::uint64_t bytes) {
  return std::to_string((bytes + (1U << 20) - 1) >> 20) + " MiB";
}

class RunCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("recipe", recipe_, "Recipe file (pipelines/*.json)");
    arguments.input("survey", survey_, "Survey folder");
    arguments.output(out_, "Folder of the results; made where it is missing");
    arguments.option("set", settings_, "stage.option=value, may be given many times");
    arguments.example("cairn run pipelines/post_flight.json samples/brighton_beach/survey -o out");
    arguments.example("cairn run pipelines/post_flight.json survey -o out --set locate.mode=paper --dry-run");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    pipeline::Recipe recipe = pipeline::read_recipe(recipe_);
    for (const auto& setting : settings_) pipeline::apply_setting(recipe, setting);
    const survey::Survey survey = io::read_survey(survey_);
    const auto inputs = pipeline::digest_inputs(pipeline::survey_files(survey_, survey));

    pipeline::ExecuteOptions options{survey_, out_, arguments.common.overwrite, arguments.common.dry_run,
                                     arguments.resolved(false)};
    const auto report = pipeline::execute(recipe, pipeline::make_stage, inputs, options, ctx);
    return {summary_of(recipe, report), text_of(report), base::ExitCode::ok};
  }

 private:
  [[nodiscard]] io::Json summary_of(const pipeline::Recipe& recipe, const pipeline::ExecuteReport& report) const {
    io::Json stages = io::Json::array();
    for (const auto& stage : report.stages)
      stages.push(io::Json::object({{"stage", stage.name},
                                    {"state", stage.state},
                                    {"seconds", stage.seconds},
                                    {"memory_bytes", static_cast<std::int64_t>(stage.estimate.memory_bytes)},
                                    {"disk_bytes", static_cast<std::int64_t>(stage.estimate.disk_bytes)},
                                    {"summary", stage.summary}}));
    return io::Json::object({{"recipe", recipe.name},
                             {"output", out_.string()},
                             {"nothing_to_do", report.nothing_to_do},
                             {"stages", stages}});
  }

  [[nodiscard]] std::string text_of(const pipeline::ExecuteReport& report) const {
    if (report.nothing_to_do) return "Nothing to do: " + out_.string() + " is complete and up to date\n";
    std::string text;
    std::uint64_t memory = 0, disk = 0;
    for (const auto& stage : report.stages) {
      std::string line = "  " + stage.name;
      line.resize(std::max<std::size_t>(line.size() + 1, 14), ' ');
      line += stage.state;
      if (stage.state == "ran") line += " in " + base::to_fixed(stage.seconds, 1) + " s";
      if (stage.state == "would run")
        line += ", memory up to " + mebibytes(stage.estimate.memory_bytes) + ", disk " +
                mebibytes(stage.estimate.disk_bytes);
      memory = std::max(memory, stage.estimate.memory_bytes);
      disk += stage.estimate.disk_bytes;
      text += line + "\n";
    }
    const bool planned = !report.stages.empty() && report.stages.back().state == "would run";
    if (planned) text += "  in all: memory up to " + mebibytes(memory) + ", disk " + mebibytes(disk) + "\n";
    else text += "Results in " + out_.string() + "\n";
    return text;
  }

  std::filesystem::path recipe_, survey_, out_;
  std::vector<std::string> settings_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::RunCommand)
