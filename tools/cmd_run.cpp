// cairn run RECIPE SURVEY -o OUT
#include <algorithm>
#include <optional>

#include "base/number_text.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/cloud_survey.hpp"
#include "pipeline/executor.hpp"
#include "pipeline/recipe.hpp"
#include "pipeline/stages.hpp"
#include "pipeline/survey_sources.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

std::string mebibytes(std::uint64_t bytes) {
  return std::to_string((bytes + (1U << 20) - 1) >> 20) + " MiB";
}

class RunCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("recipe", recipe_, "Recipe file (pipelines/*.json)");
    arguments.input("survey", survey_, "Survey folder, or a point cloud by itself");
    arguments.output(out_, "Folder of the results; made where it is missing");
    arguments.option("set", settings_, "stage.option=value, may be given many times");
    arguments.example("cairn run pipelines/post_flight.json samples/brighton_beach/survey -o out");
    arguments.option("origin", origin_, "latitude,longitude,height of a cloud's zero point where it declares no CRS");
    arguments.example("cairn run pipelines/pbr_inventory.json cloud.las -o out");
    arguments.example("cairn run pipelines/post_flight.json survey -o out --set locate.mode=paper --dry-run");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    pipeline::Recipe recipe = pipeline::read_recipe(recipe_);
    for (const auto& setting : settings_) pipeline::apply_setting(recipe, setting);
    const fs::path folder = survey_folder(arguments.common.dry_run);
    const survey::Survey survey = io::read_survey(folder);
    const auto inputs = pipeline::digest_inputs(pipeline::survey_files(folder, survey));

    pipeline::ExecuteOptions options{folder, out_, arguments.common.overwrite, arguments.common.dry_run,
                                     resolved_with(arguments, folder)};
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

  // The survey's folder; for a cloud by itself one that is made for it beside the results.
  [[nodiscard]] fs::path survey_folder(bool dry_run) const {
    if (!fs::is_regular_file(survey_)) {
      if (!origin_.empty())
        throw base::Error(base::ErrorCode::invalid_argument, "--origin is for a cloud: a survey has its own");
      return survey_;
    }
    std::optional<geometry::Geodetic> origin;
    if (!origin_.empty()) origin = pipeline::parse_origin(origin_);
    // What the executor would refuse to touch is left alone here, too.
    const bool ours = !fs::exists(out_) || fs::exists(out_ / ".cairn") || fs::is_empty(out_);
    const fs::path folder =
        dry_run || !ours ? fs::temp_directory_path() / "cairn-cloud-survey" : out_ / ".cairn" / "cloud";
    fs::create_directories(folder);
    pipeline::write_cloud_survey(survey_, origin, folder);
    return folder;
  }

  // run.json names the survey that was used, so that other commands find it.
  [[nodiscard]] static io::Json resolved_with(const Arguments& arguments, const fs::path& folder) {
    io::Json resolved = arguments.resolved(false);
    resolved.set("survey", folder.string());
    return resolved;
  }

  std::filesystem::path recipe_, survey_, out_;
  std::string origin_;
  std::vector<std::string> settings_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::RunCommand)
