// From survey records in the local frame to georeferenced layers.
#pragma once

#include <optional>
#include <vector>

#include "base/time.hpp"
#include "geodesy/local_frame.hpp"
#include "geometry/primitives.hpp"
#include "io/vector_layer.hpp"
#include "survey/coverage_gap.hpp"
#include "survey/frame.hpp"
#include "survey/manifest.hpp"
#include "survey/obstacle.hpp"
#include "survey/rock.hpp"
#include "survey/target.hpp"

namespace cairn::report {

// What the layers show; every list may be empty. Coordinates are local ENU of `origin`, m.
struct LayerRecords {
  survey::Origin origin;
  base::TimeBase time_base = base::TimeBase::unknown;
  std::vector<survey::Frame> frames;
  std::vector<geometry::Ring> footprints;  // one a frame, or none at all; an empty ring = no footprint
  std::optional<double> ground_up_m;       // local up of the plane of the footprints
  std::vector<survey::Target> targets;
  std::vector<survey::Rock> rocks;
  std::vector<survey::Obstacle> obstacles;
  std::vector<survey::CoverageGap> gaps;
};

// The six layers of layer_table(), in its order, also where they are empty; features in record order,
// with styles. Positions are converted point by point, exactly; heights keep the datum of the origin.
// A rock lies at its centre of mass, else at the centre of its target; one with neither is left without
// geometry. Quantities that follow from the tipping angle are empty where the grade is not_measurable.
[[nodiscard]] std::vector<io::Layer> build_layers(const LayerRecords& records);

// The rocks as the inventory: the columns of layer `rocks` under the name `inventory`.
[[nodiscard]] io::Layer inventory_layer(const LayerRecords& records);

}  // namespace cairn::report
