#include "pipeline/audited_surface.hpp"

#include <cmath>
#include <fstream>

#include "base/error.hpp"
#include "geodesy/crs.hpp"
#include "geometry/grid_mesh.hpp"
#include "io/mesh.hpp"
#include "io/raster.hpp"

namespace cairn::pipeline {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Grid;

bool is_tiff(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(ErrorCode::not_found, "the surface cannot be read").file(path.string());
  char head[4] = {};
  in.read(head, 4);
  const std::string_view bytes(head, 4);
  using namespace std::string_view_literals;
  return bytes == "II*\0"sv || bytes == "MM\0*"sv || bytes == "II+\0"sv || bytes == "MM\0+"sv;
}

const Grid<float>* band(const io::Raster& raster, std::string_view name) {
  for (const auto& b : raster.bands)
    if (b.name == name) return std::get_if<Grid<float>>(&b.values);
  return nullptr;
}

AuditedSurface from_raster(const std::filesystem::path& path, const std::optional<geodesy::LocalFrame>& frame) {
  const io::Raster raster = io::read_raster(path);
  if (!frame)
    throw Error(ErrorCode::failed_precondition, "a raster surface needs views in a georeferenced frame")
        .file(path.string())
        .hint("Give a survey as --views, or the surface as a mesh.");
  if (raster.crs.empty())
    throw Error(ErrorCode::crs_mismatch, "the surface declares no coordinate reference system").file(path.string());
  const Grid<float>* heights = band(raster, "surface");
  if (heights == nullptr && !raster.bands.empty()) heights = std::get_if<Grid<float>>(&raster.bands.front().values);
  if (heights == nullptr)
    throw Error(ErrorCode::invalid_input, "the raster has no band of heights").file(path.string()).allowed("Float32");
  geometry::GridMesh made = geometry::grid_mesh(*heights);
  AuditedSurface surface;
  const geodesy::CrsConverter converter(raster.crs, *frame);
  converter.to_local(made.mesh.vertices);
  surface.mesh = std::move(made.mesh);
  surface.grid = heights->geometry;
  surface.crs = raster.crs;
  surface.facet_cell = std::move(made.facet_cell);
  if (const Grid<float>* observed = band(raster, "observed")) {
    surface.observed.reserve(surface.facet_cell.size());
    for (const std::uint32_t cell : surface.facet_cell)
      surface.observed.push_back(observed->values[cell] > 0.5F ? 1 : 0);
  } else {
    surface.notes.emplace_back("the surface does not say which cells are interpolated; all are taken as observed");
  }
  return surface;
}

AuditedSurface from_mesh(const std::filesystem::path& path, const std::optional<geodesy::LocalFrame>& frame) {
  io::MeshData data = io::read_mesh(path);
  AuditedSurface surface;
  for (const auto& warning : data.facts.warnings) surface.notes.push_back(warning);
  if (!data.facts.crs.empty() && data.facts.crs != "local") {
    if (!frame)
      throw Error(ErrorCode::crs_mismatch, "the mesh declares a CRS and the views have none")
          .file(path.string())
          .found(data.facts.crs);
    const geodesy::CrsConverter converter(data.facts.crs, *frame);
    converter.to_local(data.mesh.vertices);
  }
  surface.mesh = std::move(data.mesh);
  surface.notes.emplace_back("a mesh does not say which facets are interpolated; all are taken as observed");
  return surface;
}

}  // namespace

AuditedSurface read_audited_surface(const std::filesystem::path& path,
                                    const std::optional<geodesy::LocalFrame>& frame) {
  AuditedSurface surface = is_tiff(path) ? from_raster(path, frame) : from_mesh(path, frame);
  if (surface.mesh.triangles.empty())
    throw Error(ErrorCode::invalid_input, "the surface has no facets").file(path.string()).allowed("at least 1");
  return surface;
}

}  // namespace cairn::pipeline
