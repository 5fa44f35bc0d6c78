#include "pipeline/audited_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "coverage/cylinder_mesh.hpp"
#include "geodesy/crs.hpp"
#include "geometry/grid_mesh.hpp"
#include "io/cloud.hpp"
#include "io/mesh.hpp"
#include "io/raster.hpp"
#include "io/targets_json.hpp"
#include "segmentation/terrain.hpp"

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

// Stage `terrain` writes "highest points of each cell, ellipsoidal height".
std::string named_datum(const io::Raster& raster, const Grid<float>* heights) {
  constexpr std::string_view kEnd = " height";
  for (const auto& b : raster.bands) {
    if (std::get_if<Grid<float>>(&b.values) != heights || !b.description.ends_with(kEnd)) continue;
    const std::string text = b.description.substr(0, b.description.size() - kEnd.size());
    const std::size_t comma = text.rfind(", ");
    return comma == std::string::npos ? text : text.substr(comma + 2);
  }
  return {};
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
  surface.height_datum = named_datum(raster, heights);
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

// `cairn surface` paints the vertices of facets that it closed. Empty where the mesh has other colours.
std::vector<std::uint8_t> seen_by_colour(const geometry::TriangleMesh& mesh) {
  using Colour = std::array<std::uint8_t, 3>;
  constexpr Colour kSeen{168, 150, 126}, kClosed{196, 96, 70};
  bool closed = false;
  for (const Colour& c : mesh.colours) {
    if (c != kSeen && c != kClosed) return {};
    closed = closed || c == kClosed;
  }
  if (!closed) return {};
  std::vector<std::uint8_t> observed;
  observed.reserve(mesh.triangles.size());
  for (const geometry::Triangle& t : mesh.triangles)
    observed.push_back(std::all_of(t.begin(), t.end(), [&](auto v) { return mesh.colours.at(v) == kClosed; }) ? 0 : 1);
  return observed;
}

AuditedSurface from_cloud(const std::filesystem::path& path, const std::optional<geodesy::LocalFrame>& frame,
                          base::RunContext& ctx) {
  io::CloudFile data = io::read_cloud(path);
  std::vector<geometry::Vec3>& points = data.cloud.positions;
  if (!data.facts.crs.empty() && data.facts.crs != "local") {
    if (!frame)
      throw Error(ErrorCode::crs_mismatch, "the cloud declares a CRS and the views have none")
          .file(path.string())
          .found(data.facts.crs);
    geodesy::CrsConverter(data.facts.crs, *frame).to_local(points);
  }
  const segmentation::TerrainOptions options;
  const segmentation::TerrainModel model = segmentation::model_terrain(points, options, ctx);
  geometry::GridMesh made = geometry::grid_mesh(model.surface);
  AuditedSurface surface;
  surface.mesh = std::move(made.mesh);
  surface.grid = model.surface.geometry;
  if (frame) surface.crs = frame->raster_crs_wkt();
  surface.facet_cell = std::move(made.facet_cell);
  for (const std::uint32_t cell : surface.facet_cell) surface.observed.push_back(model.observed.values[cell]);
  surface.notes.emplace_back("a terrain model of the cloud in cells of " + base::to_text(options.cell_m) +
                             " m stands for it");
  return surface;
}

AuditedSurface from_targets(const std::filesystem::path& path) {
  AuditedSurface surface;
  surface.targets_themselves = true;
  for (const survey::Target& target : io::read_targets(path).targets) {
    if (target.state == survey::TargetState::deregistered || !(target.refined || target.bcylinder)) continue;
    const geometry::VerticalCylinder& c = target.refined ? target.refined->cylinder : *target.bcylinder;
    if (!(c.height() > 0.0 && c.radius > 0.0)) {
      surface.notes.push_back("target " + std::to_string(target.id.value) +
                              " is left out: a cylinder without height or radius has no wall");
      continue;
    }
    const geometry::TriangleMesh own = coverage::cylinder_mesh(c);
    const auto offset = static_cast<std::uint32_t>(surface.mesh.vertices.size());
    surface.mesh.vertices.insert(surface.mesh.vertices.end(), own.vertices.begin(), own.vertices.end());
    for (const geometry::Triangle& t : own.triangles)
      surface.mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  surface.notes.emplace_back("the cylinders of the targets stand for the surface; nothing else is in the way");
  return surface;
}

// By the name alone: PLY may hold either, and is asked.
bool is_cloud(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".las" || extension == ".laz" || extension == ".pcd" || extension == ".xyz") return true;
  if (extension != ".ply") return false;
  std::ifstream in(path, std::ios::binary);
  for (std::string line; std::getline(in, line) && !line.starts_with("end_header");)
    if (line.starts_with("element face ") && !line.starts_with("element face 0")) return false;
  return true;
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
  surface.observed = seen_by_colour(surface.mesh);
  if (surface.observed.empty())
    surface.notes.emplace_back("a mesh does not say which facets are interpolated; all are taken as observed");
  return surface;
}

}  // namespace

AuditedSurface read_audited_surface(const std::filesystem::path& path, const std::optional<geodesy::LocalFrame>& frame,
                                    base::RunContext& ctx) {
  AuditedSurface surface = is_tiff(path)                 ? from_raster(path, frame)
                           : path.extension() == ".json" ? from_targets(path)
                           : is_cloud(path)              ? from_cloud(path, frame, ctx)
                                                         : from_mesh(path, frame);
  if (surface.mesh.triangles.empty())
    throw Error(ErrorCode::invalid_input, "the surface has no facets").file(path.string()).allowed("at least 1");
  return surface;
}

}  // namespace cairn::pipeline
