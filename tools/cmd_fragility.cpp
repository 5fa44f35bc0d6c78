// cairn fragility MESH|DIR [--contact C.csv] -o OUT
#include "base/number_text.hpp"
#include "pipeline/fragility_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

class FragilityCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.input("rocks", files_.input, "Closed mesh (PLY, OBJ, STL, GLB), or a folder of 'cairn surface'");
    arguments.output(out_, "Folder of the results");
    arguments.option("contact", files_.contact, "contact.csv: the digitised basal contact");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn fragility surfaces -o fragility --json");
    arguments.example("cairn fragility rock.ply --contact contact.csv --density 2650 -o fragility");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "fragility");
    std::vector<std::filesystem::path> named = {files_.input};
    if (!files_.contact.empty()) named.push_back(files_.contact);
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const io::Json sources = arguments.resolved(true);
    const io::Json* density = sources.find("density");
    const bool assumed = density == nullptr || density->at("source").as_string() == "default";
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"fragility", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) {
          return pipeline::fragility_files(files_, staged, assumed, options_, ctx);
        },
        ctx);
    return {outcome.summary, text_of(outcome),
            outcome.rejects.empty() ? base::ExitCode::ok : base::ExitCode::item_failures};
  }

 private:
  [[nodiscard]] std::string text_of(const pipeline::Outcome& outcome) const {
    std::string text;
    for (const auto& rock : outcome.summary.at("rocks").as_array()) {
      text += "rock " + rock.at("name").as_string() + ": " + rock.at("grade").as_string();
      if (const auto* alpha = rock.find("alpha_min_deg"))
        text += ", least angle " + base::to_fixed(alpha->as_real(), 1) + " deg towards " +
                base::to_fixed(rock.at("topple_toward_deg").as_real(), 0) + " deg, " +
                base::to_fixed(rock.at("a_qs_g").as_real(), 3) + " g";
      std::string reasons;
      for (const auto& reason : rock.at("reasons").as_array())
        reasons += (reasons.empty() ? " (" : ", ") + reason.as_string();
      text += reasons + (reasons.empty() ? "\n" : ")\n");
    }
    for (const auto& reject : outcome.rejects)
      text += reject.record + ": " + reject.reason + ", " + reject.message + "\n";
    return text + "Results in " + out_.string() + "\n";
  }

  pipeline::FragilityFiles files_;
  std::filesystem::path out_;
  fragility::FragilityOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::FragilityCommand)
