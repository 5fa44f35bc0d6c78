// Drawings of a closed loop.
#pragma once

#include <cstddef>
#include <string>

#include "pipeline/ground_run.hpp"

namespace cairn::pipeline {

// Paths over a costmap (of snapshot `index`, or none where there are fewer), with the true outlines.
[[nodiscard]] std::string drive_svg(const simulation::DriveRehearsal& rehearsal, const GroundRecord& record,
                                    std::size_t index, const std::string& title);

}  // namespace cairn::pipeline
