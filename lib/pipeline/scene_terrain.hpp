// The ground of a scene: its description and the files it names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/json_fields.hpp"
#include "simulation/scene.hpp"

namespace cairn::pipeline {

// Names files relative to a folder and remembers them.
struct SceneFiles {
  std::filesystem::path folder;
  std::vector<std::filesystem::path>& named;

  std::filesystem::path resolve(const std::string& file) {
    named.push_back(folder / file);
    return named.back();
  }
};

// Kinds: fractal; raster (GeoTIFF whose coordinates are local east-north, or are moved there); heightmap (an 8-bit
// picture stretched over a size, as simulators use); mesh.
[[nodiscard]] simulation::Terrain read_scene_terrain(JsonFields& f, SceneFiles& files);

}  // namespace cairn::pipeline
