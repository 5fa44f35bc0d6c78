// cairn segment CLOUD [--targets targets.json] [--survey SURVEY] [--picks P.csv] [--contact C.csv] -o LABELLED.las
#include "base/atomic_file.hpp"
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
    arguments.option("targets", files_.targets, "targets.json: where the rocks are; without it they are looked for");
    arguments.option("picks", files_.picks, "Table x,y,z,rock: points known to be rock (1) or not (0)");
    arguments.option("contact", files_.contact, "contact.csv: digitised contact lines, taken as they stand");
    arguments.option("survey", files_.survey, "Survey folder: where its cloud lies against its poses");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn segment model.las --targets out/targets.json --survey survey -o labelled.las --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "segment");
    std::vector<std::filesystem::path> named = {files_.cloud};
    for (const auto& file : {files_.targets, files_.picks, files_.contact})
      if (!file.empty()) named.push_back(file);
    if (!files_.survey.empty()) named.push_back(files_.survey / "survey.json");
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto contact = pipeline::contact_beside(out_);
    base::StagedFile staged_contact(contact, arguments.common.overwrite);
    const auto outcome = pipeline::run_to_file(
        out_, arguments.common.overwrite, {"segment", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) {
          return pipeline::segment_file(files_, staged, staged_contact.path(), options_, ctx);
        },
        ctx);
    staged_contact.commit();
    std::string text = std::to_string(outcome.summary.at("rocks").as_integer()) + " of " +
                       std::to_string(outcome.summary.at("targets").as_integer()) + " rocks, " +
                       std::to_string(outcome.summary.at("rocks_with_contact").as_integer()) +
                       " with their contact line, in " + out_.string() + " and " + contact.string() + "\n";
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
