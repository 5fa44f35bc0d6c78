// cairn review RESULT --edits edits.csv -o OUT
#include "pipeline/inventory_stage.hpp"
#include "pipeline/review_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class ReviewCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("result", files_.result, "Folder of 'cairn run', 'cairn review' or 'cairn fragility'");
    arguments.output(out_, "Folder of the reviewed result");
    arguments.option("edits", files_.edits, "edits.csv: the decisions, append-only");
    arguments.option("survey", files_.survey, "survey folder; taken from the result's run.json otherwise");
    arguments.example("cairn review out --edits edits.csv -o reviewed");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    if (files_.edits.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "review needs the decisions").hint("Give --edits edits.csv");
    if (fs::weakly_canonical(files_.result) == fs::weakly_canonical(out_))
      throw base::Error(base::ErrorCode::invalid_argument, "the reviewed result cannot take the place of the result")
          .found(out_.string())
          .hint("Choose another output: the result is kept as it is");
    const auto source = pipeline::inventory_source(files_.result);
    if (files_.survey.empty()) files_.survey = source.survey;
    std::vector<fs::path> named{files_.edits, files_.result / "rocks.json"};
    for (const char* name : {"labelled.las", "segments.json", "contact.csv", "review.json"})
      if (fs::exists(files_.result / name)) named.push_back(files_.result / name);
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    io::Json resolved = arguments.resolved(false);
    resolved.set("survey", files_.survey.string());
    // The rocks that are computed again draw the same numbers as in the result.
    ctx.seed = pipeline::seed_of_result(files_.result);
    io::Json extra = pipeline::carried_record(files_.result);
    extra.set("survey_name", source.name);
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite,
        {"review", std::move(resolved), ctx.seed, inputs, {}, {}, {}, std::move(extra)},
        [&](const fs::path& staged) { return pipeline::review_files(files_, staged, ctx); }, ctx);
    return {outcome.summary, text_of(outcome),
            outcome.rejects.empty() ? base::ExitCode::ok : base::ExitCode::item_failures};
  }

 private:
  [[nodiscard]] std::string text_of(const pipeline::Outcome& outcome) const {
    const auto& s = outcome.summary;
    std::string text = std::to_string(s.at("decisions").as_integer()) + " decisions";
    for (const auto& [action, n] : s.at("applied").as_object())
      text += ", " + std::to_string(n.as_integer()) + " " + action;
    text += "\n" + std::to_string(s.at("rocks").as_integer()) + " rocks, " +
            std::to_string(s.at("rejected").as_integer()) + " rejected; computed again:";
    for (const auto& id : s.at("computed_again").as_array()) text += " " + std::to_string(id.as_integer());
    text += s.at("computed_again").size() == 0 ? " none\n" : "\n";
    for (const auto& reject : outcome.rejects)
      text += reject.record + ": " + reject.reason + ", " + reject.message + "\n";
    return text + "Results in " + out_.string() + "\n";
  }

  pipeline::ReviewFiles files_;
  fs::path out_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::ReviewCommand)
