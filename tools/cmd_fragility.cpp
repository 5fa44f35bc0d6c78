// cairn fragility MESH|DIR [--contact C.csv] -o OUT
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "pipeline/fragility_stage.hpp"
#include "pipeline/rock_products.hpp"
#include "pipeline/run_record.hpp"
#include "pipeline/shake_stage.hpp"
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
    arguments.option("shake", shake_, "Records of ground motion: run them instead (AT2, SMC, COSMOS V2, tables)");
    arguments.option("scale", scale_, "Scales of the records: first:last:step, or a list");
    arguments.option("model", models_, "Published fragility models (JSON) to evaluate beside the records");
    arguments.option("pulse-tests", pulse_tests_,
                     "CSV of pga_g,pgv_over_pga_s: probability that one cosine overturns the mesh on a plane");
    arguments.options(base::bind_options(options_));
    arguments.option("survey", products_.survey, "Survey folder, for --figures: photographs with the contact line");
    arguments.options(base::bind_options(products_));
    arguments.options(base::bind_options(shake_options_));
    arguments.options(base::bind_options(pulse_options_));
    arguments.example("cairn fragility surfaces -o fragility --json");
    arguments.example("cairn fragility rock.ply --contact contact.csv --density 2650 -o fragility");
    arguments.example("cairn fragility rock.ply --shake record.AT2 --scale 0.1:2:0.1 -o shaken --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    base::validate(base::bind_options(options_), "fragility");
    base::validate(base::bind_options(products_), "fragility");
    if (!shake_.empty() || !pulse_tests_.empty()) return shake(arguments, ctx);
    std::vector<std::filesystem::path> named = {files_.input};
    if (!files_.contact.empty()) named.push_back(files_.contact);
    if (!files_.coverage.empty()) named.push_back(files_.coverage);
    if (!products_.survey.empty()) named.push_back(products_.survey / "survey.json");
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const bool assumed = density_assumed(arguments);
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"fragility", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) {
          auto result = pipeline::fragility_files(files_, staged, assumed, options_, ctx);
          pipeline::add_rock_products(files_.input, staged, products_, {}, result, ctx);
          return result;
        },
        ctx);
    return {outcome.summary, text_of(outcome),
            outcome.rejects.empty() ? base::ExitCode::ok : base::ExitCode::item_failures};
  }

 private:
  [[nodiscard]] static bool density_assumed(const Arguments& arguments) {
    const io::Json sources = arguments.resolved(true);
    const io::Json* density = sources.find("density");
    return density == nullptr || density->at("source").as_string() == "default";
  }

  // Rocking instead of tipping: records, or a table of pulses.
  CommandResult shake(const Arguments& arguments, base::RunContext& ctx) {
    base::validate(base::bind_options(shake_options_), "fragility --shake");
    base::validate(base::bind_options(pulse_options_), "fragility --pulse-tests");
    if (!shake_.empty() && !pulse_tests_.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "--shake and --pulse-tests exclude one another");
    pipeline::ShakeFiles in{
        files_.input, files_.contact, {shake_.begin(), shake_.end()}, {models_.begin(), models_.end()}};
    const auto scales = pipeline::parse_scales(scale_);
    std::vector<std::filesystem::path> named = {in.input};
    for (const auto& more : {in.contact, pulse_tests_})
      if (!more.empty()) named.push_back(more);
    named.insert(named.end(), in.records.begin(), in.records.end());
    named.insert(named.end(), in.models.begin(), in.models.end());
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    pulse_options_.eta_share_max = shake_options_.suite.eta_share_max;
    pulse_options_.rocking = shake_options_.suite.rocking;
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"fragility", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) {
          if (!pulse_tests_.empty())
            return pipeline::pulse_test_files(in.input, pulse_tests_, staged, pulse_options_, ctx);
          auto result = pipeline::shake_files(in, staged, scales, shake_options_, options_, ctx);
          if (products_.any()) {
            // The products read the tipping results, which stand beside those of the records then.
            (void)pipeline::fragility_files(files_, staged, density_assumed(arguments), options_, ctx);
            pipeline::add_rock_products(files_.input, staged, products_, {in.records, scales, shake_options_.record},
                                        result, ctx);
          }
          return result;
        },
        ctx);
    std::string text;
    if (const auto* rocks = outcome.summary.find("rocks"))
      for (const auto& rock : rocks->as_array())
        text += "rock " + rock.at("name").as_string() + ": " + rock.at("grade").as_string() + ", " +
                std::to_string(rock.at("toppled").as_integer()) + " of " +
                std::to_string(rock.at("runs").as_integer()) + " runs toppled\n";
    if (const auto* accuracy = outcome.summary.find("accuracy"))
      text += "accuracy " + base::to_fixed(accuracy->as_real(), 3) + ", Brier score " +
              base::to_fixed(outcome.summary.at("brier").as_real(), 3) + "\n";
    text += checks_text(outcome);
    for (const auto& reject : outcome.rejects)
      text += reject.record + ": " + reject.reason + ", " + reject.message + "\n";
    return {outcome.summary, text + "Results in " + out_.string() + "\n",
            outcome.rejects.empty() ? base::ExitCode::ok : base::ExitCode::item_failures};
  }

  [[nodiscard]] static std::string checks_text(const pipeline::Outcome& outcome) {
    std::string text;
    if (const auto* checks = outcome.summary.find("dynamics"))
      for (const auto& check : checks->as_array())
        text += "rock " + check.at("name").as_string() + ": " + std::to_string(check.at("toppled_3d").as_integer()) +
                " of " + std::to_string(check.at("runs").as_integer()) + " motions topple it in three dimensions, " +
                std::to_string(check.at("toppled_plane").as_integer()) + " in the plane\n";
    return text;
  }

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
    text += checks_text(outcome);
    for (const auto& reject : outcome.rejects)
      text += reject.record + ": " + reject.reason + ", " + reject.message + "\n";
    return text + "Results in " + out_.string() + "\n";
  }

  pipeline::FragilityFiles files_;
  std::filesystem::path out_, pulse_tests_;
  std::vector<std::string> shake_, models_;
  std::string scale_ = "1";
  pipeline::ShakeOptions shake_options_;
  fragility::PulseTestOptions pulse_options_;
  fragility::FragilityOptions options_;
  pipeline::RockProductOptions products_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::FragilityCommand)
