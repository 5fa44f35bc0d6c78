// The surface that a coverage audit looks at, from a raster or a mesh file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.hpp"
#include "geodesy/local_frame.hpp"
#include "geometry/grid.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::pipeline {

struct AuditedSurface {
  geometry::TriangleMesh mesh;         // local ENU of the views, m
  std::vector<std::uint8_t> observed;  // one flag a facet; empty where all were
  // Of a raster: its grid and CRS, and the cell of each facet. Empty for a mesh.
  std::optional<geometry::GridGeometry> grid;
  std::string crs;
  std::string height_datum;  // of a raster that names it: "ellipsoidal", "orthometric (egm96)", ..
  std::vector<std::uint32_t> facet_cell;
  bool targets_themselves = false;  // the mesh is the cylinders of targets
  std::vector<std::string> notes;   // what was assumed
};

// A GeoTIFF (by its first bytes), a cloud, targets.json, else a mesh of any format.
//   raster: band `surface` or the first; band `observed` (0 = interpolated) where there is one. It must declare a CRS;
//     heights are taken in the datum of the views' origin. Cells without a height are left out.
//   mesh: in the local frame, unless it declares a CRS.
//     A mesh in the two colours of `cairn surface` tells by them which facets were closed, not observed.
//   cloud (.las, .pcd, .xyz, .ply without faces): local unless it declares a CRS; made into a terrain model of
//     segmentation::TerrainOptions' defaults.
//   targets.json: the cylinders of its targets, walls and tops.
// frame: of the views; empty where they have none (a camera table): then a mesh is taken as it stands and a raster is
// refused with failed_precondition. Throws not_found, invalid_input, crs_mismatch.
[[nodiscard]] AuditedSurface read_audited_surface(const std::filesystem::path& path,
                                                  const std::optional<geodesy::LocalFrame>& frame,
                                                  base::RunContext& ctx);

}  // namespace cairn::pipeline
