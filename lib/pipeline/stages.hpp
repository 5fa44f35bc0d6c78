// All stages that a recipe can name.
#pragma once

#include <memory>
#include <string_view>

#include "pipeline/stage.hpp"

namespace cairn::pipeline {

// locate, terrain, segment, surface, fragility, coverage, obstacles, costmap, route, layers, report.
// nullptr for another name. What each reads and writes: docs/commands/run.md.
[[nodiscard]] std::unique_ptr<Stage> make_stage(std::string_view name);

}  // namespace cairn::pipeline
