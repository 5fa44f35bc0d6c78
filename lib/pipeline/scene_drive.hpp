// The member `drive` of a scene description.
#pragma once

#include "pipeline/json_fields.hpp"
#include "simulation/drive_spec.hpp"

namespace cairn::pipeline {

// Throws as read_scene.
[[nodiscard]] simulation::DriveSpec read_scene_drive(JsonFields& fields);

}  // namespace cairn::pipeline
