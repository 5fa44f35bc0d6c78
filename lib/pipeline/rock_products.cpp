#include "pipeline/rock_products.hpp"

#include "base/error.hpp"
#include "io/robot_description.hpp"
#include "pipeline/rock_results.hpp"

namespace cairn::pipeline {
namespace {

void join(Outcome& outcome, Outcome more) {
  for (const auto& [name, value] : more.summary.as_object()) outcome.summary.set(name, value);
  for (auto& reject : more.rejects) outcome.rejects.push_back(std::move(reject));
}

Outcome robot_models(const std::vector<RockResult>& results, const std::filesystem::path& out,
                     const DynamicsOptions& options) {
  io::Json list = io::Json::array();
  for (const auto& result : results) {
    if (result.mesh.triangles.empty() || !result.rock.mass) continue;
    const auto folder = out / "models" / result.stem;
    std::filesystem::create_directories(folder);
    io::RobotModelOptions model;
    model.name = (result.rock.object_class.empty() ? "rock" : result.rock.object_class) + "_" + result.stem;
    model.density_kg_m3 = result.rock.density_kg_m3;
    model.friction = options.contact.friction;
    model.restitution = options.contact.restitution;
    io::write_robot_model(folder, result.mesh, *result.rock.mass, model);
    list.push("models/" + result.stem + "/model.sdf");
  }
  Outcome outcome;
  outcome.summary = io::Json::object({{"robot_models", std::move(list)}});
  return outcome;
}

}  // namespace

void RockProductOptions::visit(base::OptionVisitor& visitor) {
  visitor.flag("figures", figures, "also sections, side views, photographs with the contact line (with --survey)");
  visitor.flag("check-3d", check_3d, "also topple each mesh in three dimensions under pulses, beside the plane model");
  visitor.flag("robot-models", robot_models, "also write each rock as SDF and URDF with its mass, inertia and centre");
  figure.visit(visitor);
  dynamics.visit(visitor);
}

void add_rock_products(const std::filesystem::path& input, const std::filesystem::path& results,
                       const RockProductOptions& options, const CheckRecords& records, Outcome& outcome,
                       base::RunContext& ctx) {
  if (!options.survey.empty() && !options.figures)
    throw base::Error(base::ErrorCode::invalid_argument, "a survey is used for figures only")
        .found("--survey without --figures")
        .hint("Add --figures");
  if (!options.any()) return;
  const auto rocks = read_rock_results(input, results);
  if (options.robot_models) join(outcome, robot_models(rocks, results, options.dynamics));
  if (options.figures) join(outcome, figure_files(rocks, input, options.survey, results, options.figure, ctx));
  if (!options.check_3d) return;
  std::vector<survey::Accelerogram> motions;
  for (const auto& file : records.files)
    for (auto& record : io::read_accelerograms(file, records.reading)) motions.push_back(std::move(record));
  join(outcome, dynamics_files(rocks, motions, records.scales, results, options.dynamics, ctx));
}

}  // namespace cairn::pipeline
