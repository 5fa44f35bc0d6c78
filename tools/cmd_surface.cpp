// cairn surface LABELLED.las [--contact C.csv] -o DIR
#include "pipeline/run_record.hpp"
#include "pipeline/surface_stage.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

class SurfaceCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("labelled", files_.labelled, "Labelled cloud of 'cairn segment'");
    arguments.output(out_, "Folder of the meshes");
    arguments.option("contact", files_.contact,
                     "contact.csv: contact lines; default LABELLED.contact.csv where it exists");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn surface labelled.las -o surfaces --json");
    arguments.example("cairn surface labelled.las -o surfaces --contact contact.csv");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "surface");
    std::vector<std::filesystem::path> named = {files_.labelled};
    if (const auto lines = pipeline::contact_file(files_); !lines.empty()) named.push_back(lines);
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"surface", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) { return pipeline::surface_file(files_, staged, options_, ctx); },
        ctx);
    std::string text =
        std::to_string(outcome.summary.at("rocks").as_integer()) + " closed surfaces in " + out_.string() + "\n";
    for (const auto& reject : outcome.rejects)
      text += "  " + reject.record + ": " + reject.reason + ", " + reject.message + "\n";
    return {outcome.summary, text, outcome.rejects.empty() ? base::ExitCode::ok : base::ExitCode::item_failures};
  }

 private:
  pipeline::SurfaceFiles files_;
  std::filesystem::path out_;
  pipeline::SurfaceOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::SurfaceCommand)
