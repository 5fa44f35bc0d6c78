// cairn inventory RESULT... [--notes FILE] [--protect] -o OUT
#include "base/number_text.hpp"
#include "pipeline/inventory_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class InventoryCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.inputs("results", results_, "Folders of 'cairn run', 'cairn review' or 'cairn fragility'");
    arguments.output(out_, "Folder of the inventory");
    arguments.option("names", names_,
                     "name of a result's survey, one a result in order; taken from the survey otherwise");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn inventory out -o inventory --notes field_notes.csv");
    arguments.example("cairn inventory north south --previous 2024/inventory.csv -o inventory");
    arguments.example("cairn inventory out --protect -o public");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "inventory");
    if (!names_.empty() && names_.size() != results_.size())
      throw base::Error(base::ErrorCode::invalid_argument, "--names needs one name a result")
          .found(std::to_string(names_.size()) + " names, " + std::to_string(results_.size()) + " results");
    std::vector<pipeline::InventorySource> sources;
    std::vector<fs::path> files;
    for (std::size_t i = 0; i < results_.size(); ++i) {
      sources.push_back(pipeline::inventory_source(results_[i]));
      if (!names_.empty()) sources.back().name = names_[i];
      for (const char* name : {"rocks.json", "targets.json", "review.json"})
        if (fs::exists(results_[i] / name)) files.push_back(results_[i] / name);
    }
    if (!options_.notes.empty()) files.emplace_back(options_.notes);
    if (!options_.previous.empty()) files.emplace_back(options_.previous);
    auto inputs = pipeline::digest_inputs(files);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    io::Json resolved = arguments.resolved(false);
    if (options_.protect) {
      // The record goes out with the inventory: names of folders and files may tell the place.
      for (auto& input : inputs) input.path = "[withheld]";
      for (const char* name : {"results", "output", "names", "notes", "previous", "config"})
        if (resolved.find(name) != nullptr) resolved.set(name, "[withheld]");
    }
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite,
        {"inventory", std::move(resolved), ctx.seed, std::move(inputs), {}, {}, {}, {}},
        [&](const fs::path& staged) { return pipeline::inventory_files(sources, staged, options_, ctx); }, ctx);
    return {outcome.summary, text_of(outcome),
            outcome.rejects.empty() ? base::ExitCode::ok : base::ExitCode::item_failures};
  }

 private:
  [[nodiscard]] std::string text_of(const pipeline::Outcome& outcome) const {
    const auto& s = outcome.summary;
    const auto count = [&](const char* name) { return std::to_string(s.at(name).as_integer()); };
    std::string text =
        count("rocks") + " rocks of " + count("surveys") + " surveys, " + count("rejected") + " rejected";
    for (const auto& [grade, n] : s.at("by_grade").as_object())
      text += ", " + std::to_string(n.as_integer()) + " " + grade;
    text += "\n";
    for (const auto& reject : outcome.rejects)
      text += reject.record + ": " + reject.reason + ", " + reject.message + "\n";
    if (options_.protect) text += s.at("coordinates").as_string() + "\n";
    return text + "Results in " + out_.string() + "\n";
  }

  std::vector<fs::path> results_;
  std::vector<std::string> names_;
  fs::path out_;
  pipeline::InventoryOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::InventoryCommand)
