// cairn coverage --surface SURFACE --views SURVEY|TABLE -o OUT
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/number_text.hpp"
#include "pipeline/coverage_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

class CoverageCommand final : public Command {
 public:
  CoverageCommand() {
    options_.facets_csv = options_.page = options_.layers = true;
    options_.colour_mesh = "verdict";
  }

  void declare(Arguments& arguments) override {
    arguments.option("surface", in_.surface, "surface: GeoTIFF of heights, mesh, cloud, or targets.json");
    arguments.option("views", in_.views, "survey folder, or table of cameras");
    arguments.choice("format", in_.format, {"auto", "survey", "mission", "pinhole-table"}, "what --views is");
    arguments.option("targets", in_.targets, "targets.json: a pass or fail row for each");
    arguments.option("contacts", in_.contacts, "contact.csv of those targets: where they rest");
    arguments.option("point", in_.points, "EAST,NORTH[,UP] in metres: which frames saw it; may be given many times");
    arguments.option("viewshed", in_.viewsheds, "EAST,NORTH[,UP] in metres: what is seen from there; likewise");
    arguments.option("gate", gates_, "completeness=0.9: exit 9 where the audit falls below; may be given many times");
    arguments.output(out_, "Folder of the result");
    arguments.options(base::bind_options(options_));
    arguments.example("cairn coverage --surface out/surface.tif --views survey --gate completeness=0.9 -o coverage");
    arguments.example("cairn coverage --surface mesh.ply --views cams.txt --format pinhole-table -o coverage --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    if (in_.surface.empty() || in_.views.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "--surface and --views are needed")
          .hint("See 'cairn coverage --help'");
    base::validate(base::bind_options(options_), "coverage");
    const auto least = parse_gates();
    pipeline::check_output_folder(out_, arguments.common.overwrite);
    std::vector<std::filesystem::path> files{in_.surface, in_.views};
    for (const auto& path : {in_.targets, in_.contacts})
      if (!path.empty()) files.push_back(path);
    if (in_.targets.empty() && !in_.contacts.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "--contacts needs --targets");
    const auto inputs = pipeline::digest_inputs(files);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"coverage", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) { return pipeline::coverage_stage(in_, staged, options_, ctx); }, ctx);

    const double completeness = outcome.summary.at("completeness").as_real();
    CommandResult result{outcome.summary, text_of(outcome.summary), base::ExitCode::ok};
    if (least) {
      const bool passed = completeness >= *least;
      result.summary.set("gate_completeness", *least);
      result.summary.set("gate_passed", passed);
      if (!passed) {
        result.exit_code = base::ExitCode::gate_failed;
        ctx.warn("The gate fails: completeness " + base::to_fixed(completeness, 4) + " is below " +
                 base::to_text(*least));
      }
    }
    return result;
  }

 private:
  [[nodiscard]] std::optional<double> parse_gates() const {
    std::optional<double> least;
    for (const std::string& gate : gates_) {
      const std::size_t equals = gate.find('=');
      const auto value = equals == std::string::npos ? std::nullopt : base::parse_real(gate.substr(equals + 1));
      if (gate.substr(0, equals) != "completeness" || !value || !(*value >= 0.0 && *value <= 1.0))
        throw base::Error(base::ErrorCode::invalid_argument, "--gate is not understood")
            .found(gate)
            .allowed("completeness=0..1");
      least = value;
    }
    return least;
  }

  [[nodiscard]] std::string text_of(const io::Json& summary) const {
    const auto percent = [](double share) { return base::to_fixed(100.0 * share, 1); };
    std::string text = "Completeness " + percent(summary.at("completeness").as_real()) + " %";
    if (const io::Json* interval = summary.find("completeness_interval_95"))
      text += " (95 % interval " + percent(interval->as_array()[0].as_real()) + " to " +
              percent(interval->as_array()[1].as_real()) + " %)";
    text += " of " + base::to_fixed(summary.at("area_m2").as_real(), 1) + " m2 observed, " +
            std::to_string(summary.at("gaps").as_integer()) + " gaps";
    if (const io::Json* sides = summary.at("sides").find("completeness"))
      text += "; sides and undersides " + percent(sides->as_real()) + " %";
    if (const io::Json* targets = summary.find("targets"))
      text += "; " + std::to_string(targets->at("passed").as_integer()) + " of " +
              std::to_string(targets->at("audited").as_integer()) + " targets pass";
    return text + "; results in " + out_.string() + "\n";
  }

  pipeline::CoverageInputs in_;
  std::filesystem::path out_;
  std::vector<std::string> gates_;
  pipeline::CoverageStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::CoverageCommand)
