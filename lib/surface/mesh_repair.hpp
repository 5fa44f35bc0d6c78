// Given meshes made closed and oriented, with every change told.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/triangle_mesh.hpp"
#include "survey/contact.hpp"

namespace cairn::surface {

struct RepairedMesh {
  geometry::TriangleMesh mesh;
  std::vector<std::uint8_t> made;  // a flag a triangle: 1 = closes a hole
  double closed_share = 0.0;       // area of the closing triangles / whole area
  double hole_share = 0.0;         // area of the holes other than the base, in their best-fit planes / whole area
  // Outline of the open base that was closed, one inferred pad; empty where there was none. Base: the largest opening,
  // if its closing face looks down (z up) and its middle lies in the lower half.
  survey::Contact base;
  double base_roughness = 0.0;  // rms of that outline about its plane, m
  // Codes, in the order of the steps: unwelded (vertices that coincide were joined), degenerate_triangles (dropped),
  // faces_turned (some did not agree with the rest), folds_removed (faces on an edge that two others share already),
  // pieces_dropped (apart from the largest piece, each below a twentieth of its area), holes_closed, base_closed.
  std::vector<std::string> notes;
};

// Holes are closed by fans about a new vertex at the middle of their rim where the rim is star-shaped about it in its
// best-fit plane, else by ears. Larger pieces stay: a mesh of two shells has several components afterwards.
// Cost n log n; ears n^2 in the vertices of a hole.
[[nodiscard]] RepairedMesh repair(const geometry::TriangleMesh& mesh);

}  // namespace cairn::surface
