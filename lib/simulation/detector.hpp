// A detector that errs: what it makes of the true boxes.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/flight.hpp"
#include "simulation/object_boxes.hpp"
#include "survey/detection.hpp"
#include "survey/truth.hpp"

namespace cairn::simulation {

// A place that deceives, drawn for one run.
struct ClutterPlace {
  geometry::Vec3 centre = geometry::Vec3::Zero();  // of its sphere
  double radius_m = 0.5;
  double hit_probability = 0.0;
  double azimuth_deg = 0.0, sector_deg = 360.0;  // of directions from the place to the camera
  std::string object_class;
};

[[nodiscard]] std::vector<ClutterPlace> place_clutter(const Scene& scene, std::uint64_t seed, const Ground& ground);

struct Detections {
  std::vector<survey::Detection> detections;  // by frame; ids from 1
  std::vector<survey::DetectionOrigin> origins;
};

// What the detector needs of a true box beside its record.
struct SeenBox {
  survey::TruthBox truth;
  double inside_share = 1.0;
};

// boxes[i] = those of exposures[i], ascending object id. Frame ids are i + 1.
[[nodiscard]] Detections detect(const Scene& scene, std::uint64_t seed, const std::vector<Exposure>& exposures,
                                const std::vector<std::vector<SeenBox>>& boxes,
                                const std::vector<PlacedObject>& objects, const std::vector<ClutterPlace>& clutter,
                                const Obstruction& obstruction);

}  // namespace cairn::simulation
