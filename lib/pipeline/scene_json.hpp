// Scene descriptions as JSON (docs/formats/scene.md is the contract of every field).
#pragma once

#include <filesystem>
#include <vector>

#include "simulation/scene.hpp"

namespace cairn::pipeline {

// Reads a scene and the files it names (terrain rasters, meshes), which are relative to the scene's folder.
// A member "extends" names another scene whose members stand where this one has none.
// Throws invalid_input with the file and the path of the member ("flights[0].speed_m_s") for an unknown or missing
// member, another kind of value, or a value out of range; not_found for a file that is not there.
[[nodiscard]] simulation::Scene read_scene(const std::filesystem::path& path);

// The scene's file, those it extends and those it names: all that a survey made from it depends on.
[[nodiscard]] std::vector<std::filesystem::path> scene_files(const std::filesystem::path& path);

}  // namespace cairn::pipeline
