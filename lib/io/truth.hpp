// truth.json and the tables in truth/: what a simulated survey knows about itself
// (docs/formats/survey_folder.md is the contract of every field).
#pragma once

#include <filesystem>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "survey/manifest.hpp"
#include "survey/truth.hpp"

namespace cairn::io {

// Writes truth.json, truth/frames.csv, truth/boxes.csv and truth/detections.csv into an existing survey folder. Files
// that objects name in `mesh` are written by write_truth_mesh. Throws invalid_input where a number is not finite,
// resource_exhausted where a write fails.
void write_truth(const survey::Truth& truth, const survey::Origin& frame, const std::filesystem::path& folder);

// truth/meshes/<id>.ply: where the mesh of an object goes, relative to the survey folder.
[[nodiscard]] std::string truth_mesh_name(survey::ObjectId id);
void write_truth_mesh(const std::filesystem::path& folder, survey::ObjectId id, const geometry::TriangleMesh& mesh);

// `path`: the file truth.json; its tables lie in the folder truth/ beside it. Records come back in the order of
// survey::Truth; reads back bit for bit what was written. Throws invalid_input with file and record for an unknown
// schema version, a duplicate id, a box of an unknown frame or object, a box that ends before it begins, a share
// outside 0..1, a cylinder that ends before it begins; not_found for a missing file. Cost linear in bytes.
[[nodiscard]] survey::Truth read_truth(const std::filesystem::path& path);

}  // namespace cairn::io
