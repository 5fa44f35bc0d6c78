// The figure of stage `vehicle`.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "ground/pose_filter.hpp"
#include "survey/ground_vehicle.hpp"

namespace cairn::pipeline {

// SVG: the tracks in the plane (log, filter, projected positions taken and refused, truth), and over time the errors
// where the truth is known, else the residuals. A track is drawn with at most 2000 points.
[[nodiscard]] std::string vehicle_plot(std::span<const survey::VehicleState> filtered,
                                       std::span<const survey::VehicleState> log,
                                       std::span<const survey::VehicleState> truth,
                                       const std::vector<ground::PoseUpdate>& updates);

}  // namespace cairn::pipeline
