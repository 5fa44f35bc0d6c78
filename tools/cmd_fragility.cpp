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
    arguments.option("coverage", files_.coverage,
                     "Folder of 'cairn coverage' (or its gaps.json), same frame as the mesh");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn fragility surfaces -o fragility --json");
    arguments.example("cairn fragility rock.ply --contact contact.csv --density 2650 -o fragility");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "fragility");
    std::vector<std::filesystem::path> named = {files_.input};
    if (!files_.contact.empty()) named.push_back(files_.contact);
    if (!files_.coverage.empty()) named.push_back(files_.coverage);
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
  // What the draws and the contact's bounds leave open.
  [[nodiscard]] static std::string spread_of(const io::Json& rock) {
    std::string text;
    if (const auto* quantiles = rock.find("quantiles"))
      if (const auto* alpha = quantiles->find("alpha_min_deg"))
        text += ", 90 %: " + base::to_fixed(alpha->at("p05").as_real(), 1) + " to " +
                base::to_fixed(alpha->at("p95").as_real(), 1) + " deg";
    const auto& interval = rock.at("alpha_interval_deg").as_array();
    if (interval[1].is_null()) return text;
    const std::string high = base::to_fixed(interval[1].as_real(), 1) + " deg";
    if (interval[0].is_null()) return text + ", contact: at most " + high;
    return text + ", contact bounds " + base::to_fixed(interval[0].as_real(), 1) + " to " + high;
  }

  [[nodiscard]] static std::string mass_of(const io::Json& rock) {
    return ", " + base::to_fixed(rock.at("mass_kg").as_real(), 0) + " kg at " +
           base::to_fixed(rock.at("density_kg_m3").as_real(), 0) + " kg/m3" +
           (rock.at("density_assumed").as_bool() ? " (assumed)" : "");
  }

  [[nodiscard]] std::string text_of(const pipeline::Outcome& outcome) const {
    std::string text;
    for (const auto& rock : outcome.summary.at("rocks").as_array()) {
      text += "rock " + rock.at("name").as_string() + ": " + rock.at("grade").as_string();
      if (const auto* alpha = rock.find("alpha_min_deg"))
        text += ", least angle " + base::to_fixed(alpha->as_real(), 1) + " deg towards " +
                base::to_fixed(rock.at("topple_toward_deg").as_real(), 0) + " deg, " +
                base::to_fixed(rock.at("a_qs_g").as_real(), 3) + " g" + spread_of(rock);
      text += mass_of(rock);
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
