// cairn costmap [--prior MAP] [--surface DSM] [--obstacles OBSTACLES] [--scans LIDAR --vehicle VEHICLE] -o OUT
#include "base/number_text.hpp"
#include "pipeline/costmap_stage.hpp"
#include "pipeline/run_record.hpp"
#include "tools/command.hpp"

namespace cairn::tools {
namespace {

class CostmapCommand final : public Command {
 public:
  void declare(Arguments& arguments) override {
    arguments.option("prior", in_.prior, "Prior map: ROS map (.yaml), GeoTIFF, or polygons (.gpkg, .geojson)");
    arguments.option("surface", in_.surface, "surface model (GeoTIFF); cells without a height are unknown");
    arguments.option("obstacles", in_.obstacles, "obstacles.json or layers.gpkg of 'cairn obstacles'");
    arguments.option("scans", in_.scans, "lidar.csv: scans of the vehicle, with --vehicle");
    arguments.option("vehicle", in_.vehicle, "vehicle.csv: log or filtered track of the vehicle");
    arguments.option("survey", in_.survey, "Survey folder that names the local frame, where no other source does");
    arguments.output(out_, "Folder of the result");
    arguments.option("radius", radius_, "The same as --radius-m");
    arguments.option("resolution", resolution_, "The same as --resolution-m");
    arguments.options(base::bind_options(options_));
    arguments.example(
        "cairn costmap --prior map.yaml --obstacles layers.gpkg --scans lidar.csv --vehicle vehicle.csv --radius 0.4 "
        "-o "
        "cost");
    arguments.example("cairn costmap --obstacles out/obstacles.json --surface out/surface.tif --radius-m 0.4 -o cost");
  }

  CommandResult run(const Arguments& arguments, base::RunContext& ctx) override {
    take("radius", radius_, options_.cost.radius_m);
    take("resolution", resolution_, options_.cost.resolution_m);
    base::validate(base::bind_options(options_), "costmap");
    const auto files = pipeline::costmap_files(in_);
    if (files.empty() && options_.extent.empty())
      throw base::Error(base::ErrorCode::invalid_argument, "--prior, --surface or --extent is needed")
          .hint("See 'cairn costmap --help'");
    const auto inputs = pipeline::digest_inputs(files);
    if (arguments.common.dry_run) return {io::Json::object({{"would_write", out_.string()}}), "Inputs can be read\n"};
    const auto outcome = pipeline::run_to_folder(
        out_, arguments.common.overwrite, {"costmap", arguments.resolved(false), ctx.seed, inputs, {}, {}, {}, {}},
        [&](const std::filesystem::path& staged) { return pipeline::costmap_stage(in_, staged, options_, ctx); }, ctx);
    return {outcome.summary, "Costmap and ROS map in " + out_.string() + "\n"};
  }

 private:
  static void take(const std::string& name, const std::string& text, double& value) {
    if (text.empty()) return;
    const auto number = base::parse_real(text);
    if (!number)
      throw base::Error(base::ErrorCode::invalid_argument, "--" + name + " is not a number").found("'" + text + "'");
    value = *number;
  }

  pipeline::CostmapInputs in_;
  std::filesystem::path out_;
  std::string radius_, resolution_;
  pipeline::CostmapStageOptions options_;
};

}  // namespace
}  // namespace cairn::tools

CAIRN_COMMAND_MAIN(cairn::tools::CostmapCommand)
