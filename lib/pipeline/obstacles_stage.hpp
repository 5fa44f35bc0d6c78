// Stage `obstacles`: targets, detections, poses and terrain -> obstacles of a ground vehicle.
#pragma once

#include <filesystem>
#include <memory>

#include "base/run_context.hpp"
#include "ground/obstacle_map.hpp"
#include "ground/obstacles.hpp"
#include "ground/projector.hpp"
#include "pipeline/outcome.hpp"
#include "pipeline/stage.hpp"

namespace cairn::pipeline {

struct ObstaclesInputs {
  std::filesystem::path survey;   // survey folder
  std::filesystem::path targets;  // targets.json; "" = every detection is projected
  std::filesystem::path terrain;  // surface.tif; "" = the foot is taken from the object's own height, or from a plane
};

struct ObstaclesStageOptions {
  ground::ObstacleOptions located;       // objects that several images located
  bool project = true;                   // the detections of no located object as well
  ground::ProjectionOptions projection;  // `mode` is that of the stage: paper projects all and takes no targets
  ground::ObstacleMapOptions map;        // its classes are those of `located`

  ObstaclesStageOptions() {
    projection.ground_up_m = kFromSurvey;
    // Photographs may show an object once: one look without a miss is enough.
    map.confirm_probability = 0.8;
  }
  static constexpr double kFromSurvey = -1.0e9;
  void visit(base::OptionVisitor& visitor) {
    projection.visit(visitor);
    located.visit(visitor);
    visitor.flag("project", project, "project the detections that belong to no located object");
    map.visit(visitor);
  }
};

// What is written into `out` beside obstacles.json.
struct ObstaclesProducts {
  bool packets = false;  // packets.bin: a packet a frame, as the aircraft would have sent it, arriving when captured
  bool layers = false;   // layers.gpkg (obstacles, footprints) and obstacles.geojson
};

// The plane where no terrain is known: option ground-up-m, else the median terrain below the frames, else the median
// of the tie points, else of the located objects' feet, else 0 with a warning.
// Throws crs_mismatch where the targets or the terrain are in another frame than the survey, failed_precondition
// where there are neither targets nor detections.
Outcome obstacles_stage(const ObstaclesInputs& in, const std::filesystem::path& out,
                        const ObstaclesStageOptions& options, base::RunContext& ctx,
                        const ObstaclesProducts& products = {});

// The recipe's stage `obstacles`.
[[nodiscard]] std::unique_ptr<Stage> make_obstacles_stage();

}  // namespace cairn::pipeline
