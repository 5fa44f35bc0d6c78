// cairn report RESULTS -o REPORT
#include "base/number_text.hpp"
#include "io/json.hpp"
#include "pipeline/report_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class ReportCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("results", results_, "Folder with targets.json, rocks.json, surface.tif and the other products");
    arguments.output(out_, "Folder of the report");
    arguments.option("survey", survey_, "Survey folder; default: the one that run.json of the results names");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn report out -o report");
    arguments.example("cairn report out --survey survey -o report --title 'Brighton Beach' --no-photos");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "report");
    if (!fs::is_directory(results_))
      throw base::Error(base::ErrorCode::not_found, "the folder of results does not exist").file(results_.string());
    pipeline::ReportInputs in{results_, survey_.empty() ? survey_of_results(ctx) : survey_, {}, true};
    const auto inputs = pipeline::digest_inputs(products());
    if (inputs.empty())
      throw base::Error(base::ErrorCode::invalid_input, "there is nothing to report")
          .file(results_.string())
          .allowed("a folder with targets.json, rocks.json, obstacles.json, coverage.json or a raster");
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"report", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) { return pipeline::report_stage(in, staged, options_, ctx); }, ctx);
    const double size = static_cast<double>(outcome.summary.at("bytes").as_integer()) / 1e6;
    return {outcome.summary, "Report of " + base::to_fixed(size, 1) + " MB: " + (out_ / "index.html").string() + "\n"};
  }

 private:
  [[nodiscard]] std::vector<fs::path> products() const {
    std::vector<fs::path> files;
    for (const char* name : {"targets.json", "rocks.json", "obstacles.json", "coverage.json", "gaps.json",
                             "surface.tif", "views.tif", "costmap.tif", "route.json"})
      if (fs::exists(results_ / name)) files.push_back(results_ / name);
    return files;
  }

  [[nodiscard]] fs::path survey_of_results(base::RunContext& ctx) const {
    if (const fs::path file = results_ / "run.json"; fs::exists(file)) {
      const io::Json record = io::read_json(file);
      const io::Json* arguments = record.find("arguments");
      const io::Json* survey = arguments == nullptr || !arguments->is_object() ? nullptr : arguments->find("survey");
      if (survey != nullptr && survey->is_string() && fs::exists(fs::path(survey->as_string()) / "survey.json"))
        return survey->as_string();
    }
    ctx.warn("no survey is known: the report has no photographs; give --survey");
    return {};
  }

  fs::path results_, out_, survey_;
  pipeline::ReportStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::ReportCommand)
