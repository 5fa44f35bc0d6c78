#include "pipeline/scene_terrain.hpp"

#include <cmath>

#include "base/error.hpp"
#include "io/image.hpp"
#include "io/mesh.hpp"
#include "io/raster.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using simulation::Terrain;
using simulation::TerrainKind;

void vec2(JsonFields& f, std::string_view name, Vec2& value) {
  if (const auto v = f.reals(name, 2)) value = {(*v)[0], (*v)[1]};
}

std::string file_of(JsonFields& f) {
  f.require("file");
  std::string file;
  f.text("file", file);
  return file;
}

void fractal(JsonFields& f, Terrain& t) {
  vec2(f, "min", t.min);
  vec2(f, "max", t.max);
  f.real("cell_m", t.cell_m);
  f.real("base_up_m", t.base_up_m);
  f.real("slope_east", t.slope_east);
  f.real("slope_north", t.slope_north);
  f.real("relief_m", t.relief_m);
  f.real("wavelength_m", t.wavelength_m);
  f.real("roughness", t.roughness);
  f.seed("seed", t.seed);
}

// Moves the grid so that `shift` becomes (0, 0, 0).
void raster(JsonFields& f, Terrain& t, const std::filesystem::path& path) {
  auto raster = io::read_raster(path);
  auto* heights = raster.bands.empty() ? nullptr : std::get_if<geometry::Grid<float>>(&raster.bands[0].values);
  if (heights == nullptr)
    throw base::Error(base::ErrorCode::invalid_input, "the first band holds no heights")
        .file(path.string())
        .allowed("a float band, m");
  Vec3 shift = Vec3::Zero();
  if (const auto v = f.reals("shift_m", 3)) shift = {(*v)[0], (*v)[1], (*v)[2]};
  t.heights = std::move(*heights);
  t.heights.geometry.west -= shift.x();
  t.heights.geometry.north -= shift.y();
  for (float& h : t.heights.values) h -= static_cast<float>(shift.z());
}

// Value 0 lies at the height of `centre_m`, 255 size_m[2] above it; the picture's columns run east, its rows south, and
// its outermost pixels' centres lie on the border (as Gazebo samples 2^n + 1 pixels).
void heightmap(JsonFields& f, Terrain& t, const std::filesystem::path& path) {
  f.require("size_m");
  const auto size = f.reals("size_m", 3);
  Vec3 centre = Vec3::Zero();
  if (const auto v = f.reals("centre_m", 3)) centre = {(*v)[0], (*v)[1], (*v)[2]};
  const auto image = io::read_grey_image(path);
  if (image.width_px < 2 || image.height_px < 2)
    f.fail("file", "a heightmap of one pixel", std::to_string(image.width_px), "at least 2 x 2 pixels");
  auto& mesh = t.mesh;
  const auto columns = static_cast<std::uint32_t>(image.width_px), rows = static_cast<std::uint32_t>(image.height_px);
  for (std::uint32_t r = 0; r < rows; ++r)
    for (std::uint32_t c = 0; c < columns; ++c)
      mesh.vertices.emplace_back(centre.x() + (*size)[0] * (c / (columns - 1.0) - 0.5),
                                 centre.y() - (*size)[1] * (r / (rows - 1.0) - 0.5),
                                 centre.z() + (*size)[2] * image.at(r, c) / 255.0);
  for (std::uint32_t r = 0; r + 1 < rows; ++r)
    for (std::uint32_t c = 0; c + 1 < columns; ++c) {
      const std::uint32_t nw = r * columns + c, ne = nw + 1, sw = nw + columns, se = sw + 1;
      mesh.triangles.push_back({sw, se, ne});
      mesh.triangles.push_back({sw, ne, nw});
    }
  // Only a part of a large heightmap is flown over.
  if (!f.has("min") && !f.has("max")) return;
  vec2(f, "min", t.min);
  vec2(f, "max", t.max);
  std::vector<geometry::Triangle> kept;
  for (const auto& triangle : mesh.triangles) {
    const Vec3 p = (mesh.vertices[triangle[0]] + mesh.vertices[triangle[1]] + mesh.vertices[triangle[2]]) / 3.0;
    if (p.x() >= t.min.x() && p.y() >= t.min.y() && p.x() <= t.max.x() && p.y() <= t.max.y()) kept.push_back(triangle);
  }
  std::vector<std::int64_t> index(mesh.vertices.size(), -1);
  geometry::TriangleMesh part;
  for (auto triangle : kept) {
    for (auto& v : triangle) {
      if (index[v] < 0) {
        index[v] = static_cast<std::int64_t>(part.vertices.size());
        part.vertices.push_back(mesh.vertices[v]);
      }
      v = static_cast<std::uint32_t>(index[v]);
    }
    part.triangles.push_back(triangle);
  }
  mesh = std::move(part);
}

}  // namespace

Terrain read_scene_terrain(JsonFields& f, SceneFiles& files) {
  Terrain t;
  f.require("kind");
  f.text("material", t.material);
  switch (*f.choice("kind", {"fractal", "raster", "heightmap", "mesh"})) {
    case 0: fractal(f, t); break;
    case 1:
      t.kind = TerrainKind::grid;
      raster(f, t, files.resolve(file_of(f)));
      break;
    case 2:
      t.kind = TerrainKind::mesh;
      heightmap(f, t, files.resolve(file_of(f)));
      break;
    default:
      t.kind = TerrainKind::mesh;
      t.mesh = io::read_mesh(files.resolve(file_of(f))).mesh;
      if (const auto v = f.reals("shift_m", 3))
        for (Vec3& p : t.mesh.vertices) p -= Vec3((*v)[0], (*v)[1], (*v)[2]);
  }
  return t;
}

}  // namespace cairn::pipeline
