// cairn refine SURVEY -o SURVEY2
#include "base/number_text.hpp"
#include "io/survey_folder.hpp"
#include "pipeline/refine_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class RefineCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("survey", in_.survey, "Survey folder with tie points, or with images for --match");
    arguments.output(out_, "Folder of the refined survey");
    arguments.option("control", in_.control, "Ground control points: gcp_list.txt, OpenSfM's JSON, or a CSV table");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn refine samples/brighton_beach/survey -o refined --json");
    arguments.example("cairn refine survey --match --control gcp_list.txt -o refined");
    arguments.example("cairn refine survey --intrinsics radial --prior-sigma-xy-m 2 --prior-sigma-z-m 4 -o refined");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    std::vector<fs::path> named{in_.survey / "survey.json", in_.survey / "frames.csv"};
    for (const auto* optional : {"detections.csv", "tie_points.csv", "tie_observations.csv"})
      if (fs::exists(in_.survey / optional)) named.push_back(in_.survey / optional);
    if (!in_.control.empty()) named.push_back(in_.control);
    if (options_.match)
      for (const auto& frame : io::read_survey(in_.survey).frames)
        if (const auto image = io::resolve_reference(frame.image, in_.survey); fs::exists(image))
          named.push_back(image);
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) {
      const auto survey = io::read_survey(in_.survey);
      return {
          io::Json::object(
              {{"would_write", out_.string()}, {"frames", survey.frames.size()}, {"tie_points", survey.ties.size()}}),
          "Inputs can be read: " + std::to_string(survey.frames.size()) + " frames, " +
              std::to_string(survey.ties.size()) + " tie points\n"};
    }
    in_.final_folder = out_;
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"refine", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) { return pipeline::refine_stage(in_, staged, options_, ctx); }, ctx);
    return {outcome.summary, text_of(outcome.summary)};
  }

 private:
  [[nodiscard]] std::string text_of(const io::Json& summary) const {
    const auto count = [&](const char* name) { return std::to_string(summary.at(name).as_integer()); };
    const auto pixels = [&](const char* name) { return base::to_fixed(summary.at(name).as_real(), 2); };
    std::string text = count("frames_adjusted") + " of " + count("frames") + " frames adjusted by " + count("points") +
                       " tie points (" + count("observations") +
                       " observations), datum: " + summary.at("gauge").as_string() + "; residual " +
                       pixels("rms_before_px") + " px before, " + pixels("rms_after_px") + " px after" +
                       (summary.at("converged").as_bool() ? "" : ", not converged") + "\n";
    for (const auto& point : summary.at("control_points").as_array())
      text += point.at("use").as_string() + " point " + point.at("name").as_string() + ": " +
              base::to_fixed(point.at("before_m").as_vec3().norm(), 3) + " m before, " +
              base::to_fixed(point.at("after_m").as_vec3().norm(), 3) + " m after\n";
    return text + "Survey in " + out_.string() + "\n";
  }

  pipeline::RefineInputs in_;
  fs::path out_;
  pipeline::RefineStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::RefineCommand)
