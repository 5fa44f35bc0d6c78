// cairn track SURVEY -o tracks.csv, cairn track DET.txt... -o OUT.txt|DIR
#include "base/atomic_file.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/run_record.hpp"
#include "pipeline/track_stage.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::ErrorCode;

class TrackCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.inputs("inputs", inputs_, "A survey folder with detections, or files of boxes, one a sequence");
    arguments.output(out_, "tracks.csv of a survey; a MOT file; a folder of MOT files, one an input");
    std::vector<std::string> formats{"auto"};
    formats.insert(formats.end(), io::box_format_names().begin(), io::box_format_names().end());
    arguments.choice("format", files_.format, formats, "Format of the files; auto: recognised from their content");
    arguments.option("names", names_, "Class names of a format that numbers classes, one a line");
    arguments.option("images", files_.reading.images, "yolo: folder of the images, for their sizes");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn track det.txt --format mot --min-hits 3 --max-age 1 --iou 0.3 -o out.txt");
    arguments.example("cairn track MOT15/train/*/det/det.txt -o results");
    arguments.example("cairn track survey --preset paper -o tracks.csv");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    static_cast<void>(tracking::resolved(options_.sort));
    if (inputs_.empty()) throw Error(ErrorCode::invalid_argument, "no input").hint("Name a survey or files of boxes");
    if (!names_.empty()) files_.reading.class_names = io::read_class_names(names_);
    for (const auto& input : inputs_)
      if (!fs::exists(input))
        throw Error(ErrorCode::not_found, "no such file").file(input.string()).hint("Check the path");
    const bool survey = fs::exists(inputs_.front() / "survey.json");
    if (survey && inputs_.size() > 1)
      throw Error(ErrorCode::invalid_argument, "several inputs, and the first is a survey")
          .hint("Track one survey at a time");
    const bool folder = !survey && (inputs_.size() > 1 || fs::is_directory(out_) || out_.filename().empty());
    if (folder) return to_folder(arguments, ctx);
    return to_file(arguments, ctx, survey);
  }

 private:
  [[nodiscard]] pipeline::RunRecord record(const Arguments& arguments, const base::RunContext& ctx,
                                           const std::vector<fs::path>& named) const {
    return {"track", arguments.resolved(false), ctx.seed, pipeline::digest_inputs(named), {}, {}, {}, {}};
  }

  CommandResult to_folder(const Arguments& arguments, base::RunContext& ctx) {
    pipeline::check_output_folder(out_, arguments.common.overwrite);
    static_cast<void>(pipeline::results_in_folder(inputs_, out_));
    if (arguments.common.dry_run) return planned();
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, record(arguments, ctx, inputs_),
        [&](const fs::path& staged) {
          return pipeline::track_files(pipeline::results_in_folder(inputs_, staged), files_, options_, ctx);
        },
        ctx);
    return result(outcome);
  }

  CommandResult to_file(const Arguments& arguments, base::RunContext& ctx, bool survey) {
    std::vector<fs::path> named = inputs_;
    if (survey)
      named = {inputs_.front() / "survey.json", inputs_.front() / "frames.csv", inputs_.front() / "detections.csv"};
    if (survey && !fs::exists(named.back())) named.pop_back();
    if (arguments.common.dry_run) return planned();
    const auto outcome = pipeline::run_to_file(
        out_, arguments.common.overwrite, record(arguments, ctx, named),
        [&](const fs::path& staged) {
          return survey ? pipeline::track_survey(inputs_.front(), staged, options_, ctx)
                        : pipeline::track_files({{inputs_.front(), staged}}, files_, options_, ctx);
        },
        ctx);
    return result(outcome);
  }

  [[nodiscard]] CommandResult planned() const {
    return {io::Json::object({{"would_write", out_.string()}, {"inputs", inputs_.size()}}),
            "Would write " + out_.string() + "\n"};
  }

  [[nodiscard]] CommandResult result(const pipeline::Outcome& outcome) const {
    const auto count = [&](const char* name) { return std::to_string(outcome.summary.at(name).as_integer()); };
    std::string text = count("tracks") + " tracks over " + count("frames") + " frames from " + count("used") + " of " +
                       count("boxes") + " boxes; " + count("rows") + " rows, " + count("coasted_rows") +
                       " of them coasted\n";
    return {outcome.summary, text + "Result in " + out_.string() + "\n"};
  }

  std::vector<fs::path> inputs_;
  fs::path out_, names_;
  pipeline::TrackFileInputs files_;
  pipeline::TrackStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::TrackCommand)
