// cairn plan lawnmower|cylinder|gaps [COVERAGE] -o PLAN
#include "base/number_text.hpp"
#include "pipeline/plan_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

namespace fs = std::filesystem;

class PlanCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.word("kind", options_.kind, {"lawnmower", "cylinder", "gaps"}, "What to plan");
    arguments.input("coverage", in_.coverage, "gaps: result of 'cairn coverage', or of a recipe with it", false);
    arguments.output(out_, "Folder of the result");
    arguments.option("area", in_.area, "lawnmower: polygons (GeoJSON, GeoPackage, Shapefile)");
    arguments.option("targets", in_.targets, "cylinder, gaps: targets.json");
    arguments.option("terrain", in_.terrain, "surface to stay clear of: GeoTIFF of heights, or mesh");
    arguments.option("survey", in_.survey, "survey whose camera and frame are taken");
    arguments.option("overlap", overlap_, "lawnmower: FRONT,SIDE as fractions, in place of the two options");
    arguments.option("budget", budget_, "longest flight: 15min, 900s, 0.5h");
    arguments.options(base::bind_options(options_));
    arguments.example(
        "cairn plan lawnmower --area field.geojson --gsd 0.01 --overlap 0.8,0.7 --terrain dsm.tif -o plan");
    arguments.example("cairn plan cylinder --targets located/targets.json -o plan");
    arguments.example("cairn plan gaps coverage --budget 15min -o plan --json");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    if (!overlap_.empty()) take_overlap();
    if (!budget_.empty()) options_.budget_s = pipeline::parse_duration(budget_);
    base::validate(base::bind_options(options_), "plan");
    std::vector<fs::path> named;
    for (const fs::path& path : {in_.area, in_.targets, in_.terrain, in_.survey, in_.coverage})
      if (!path.empty()) named.push_back(path);
    if (named.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "nothing to plan for")
          .hint("Give --area, --targets or the folder of a coverage audit");
    pipeline::check_output_folder(out_, arguments.common.overwrite);
    const auto inputs = pipeline::digest_inputs(named);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"plan", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const fs::path& staged) { return pipeline::plan_stage(in_, staged, options_, ctx); }, ctx);
    CommandResult result{outcome.summary, text_of(outcome.summary), base::ExitCode::ok};
    result.summary.set("rejects", pipeline::count_by_reason(outcome.rejects));
    if (!outcome.rejects.empty()) {
      result.exit_code = base::ExitCode::item_failures;
      for (const auto& reject : outcome.rejects) ctx.warn(reject.record + ": " + reject.message);
    }
    return result;
  }

 private:
  void take_overlap() {
    const std::size_t comma = overlap_.find(',');
    const auto front = base::parse_real(overlap_.substr(0, comma));
    const auto side = comma == std::string::npos ? front : base::parse_real(overlap_.substr(comma + 1));
    if (!front || !side)
      throw base::Error(base::ErrorCode::invalid_argument, "--overlap is not understood")
          .found(overlap_)
          .allowed("FRONT,SIDE, such as 0.8,0.7");
    options_.lawnmower.front_overlap = *front;
    options_.lawnmower.side_overlap = *side;
  }

  [[nodiscard]] std::string text_of(const io::Json& s) const {
    return "DRAFT: " + std::to_string(s.at("images").as_integer()) + " images on " +
           base::to_fixed(s.at("length_m").as_real(), 0) + " m in " +
           base::to_fixed(s.at("duration_s").as_real() / 60.0, 1) + " min; peaks " +
           base::to_fixed(s.at("peak_speed_m_s").as_real(), 2) + " m/s, " +
           base::to_fixed(s.at("peak_acceleration_m_s2").as_real(), 2) + " m/s2\nMission in " + out_.string() +
           "; check it before flight\n";
  }

  pipeline::PlanInputs in_;
  fs::path out_;
  std::string overlap_, budget_;
  pipeline::PlanStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::PlanCommand)
