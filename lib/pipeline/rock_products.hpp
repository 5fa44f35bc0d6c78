// What `cairn fragility` can write beside its results: figures, the 3-D check, models for simulators.
#pragma once

#include <filesystem>
#include <vector>

#include "base/run_context.hpp"
#include "io/accelerogram.hpp"
#include "pipeline/dynamics_stage.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/rock_figures.hpp"

namespace cairn::pipeline {

struct RockProductOptions {
  bool figures = false;       // see figure_files
  bool check_3d = false;      // see dynamics_files
  bool robot_models = false;  // models/<stem>/{model.sdf, model.urdf, model.config, mesh.obj} of every rock with a mesh
  std::filesystem::path survey;  // for photographs; "" = none
  FigureOptions figure;
  DynamicsOptions dynamics;

  [[nodiscard]] bool any() const { return figures || check_3d || robot_models; }
  // The three flags and the options of each.
  void visit(base::OptionVisitor& visitor);
};

// Motions of the 3-D check in place of its pulses; empty = the pulses.
struct CheckRecords {
  std::vector<std::filesystem::path> files;
  std::vector<double> scales;
  io::RecordOptions reading;
};

// Adds to the folder that fragility_files wrote, and to its outcome: members "figures", "dynamics", "robot_models" of
// the summary, and rejects. input: the mesh or folder that fragility read. Throws invalid_argument where a survey is
// given without figures.
void add_rock_products(const std::filesystem::path& input, const std::filesystem::path& results,
                       const RockProductOptions& options, const CheckRecords& records, Outcome& outcome,
                       base::RunContext& ctx);

}  // namespace cairn::pipeline
