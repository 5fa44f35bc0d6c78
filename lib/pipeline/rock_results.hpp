// What `cairn fragility` wrote, with the meshes it was computed from: input of everything that comes after it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "survey/rock.hpp"

namespace cairn::pipeline {

struct RockResult {
  std::string stem;  // of its files
  survey::Rock rock;
  geometry::TriangleMesh mesh;  // closed, outward; empty where the rock has none
};

// rocks: rocks.json in `results`; meshes: `input` itself where it is a mesh, else <id>.ply in that folder. Records of
// rejected rocks come without a mesh. Throws failed_precondition where a mesh is not the one of its record.
[[nodiscard]] std::vector<RockResult> read_rock_results(const std::filesystem::path& input,
                                                        const std::filesystem::path& results);

}  // namespace cairn::pipeline
