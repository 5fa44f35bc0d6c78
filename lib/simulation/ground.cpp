#include "simulation/ground.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.hpp"
#include "geometry/grid_mesh.hpp"
#include "simulation/noise.hpp"

namespace cairn::simulation {
namespace {

using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

void add_noise(const Terrain& terrain, std::vector<Vec3>& vertices) {
  std::vector<double> noise(vertices.size(), 0.0);
  double amplitude = 1.0, wavelength = terrain.wavelength_m;
  for (std::uint64_t octave = 0; wavelength >= 2.0 * terrain.cell_m && amplitude > 1e-4; ++octave) {
    base::Random random(terrain.seed, "simulation terrain", octave);
    const std::uint64_t key = random.bits();
    // Turned for each octave, so that the lattice's directions do not show in the sum.
    const double angle = random.uniform(0.0, 1.5), c = std::cos(angle), s = std::sin(angle);
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const double x = vertices[i].x() / wavelength, y = vertices[i].y() / wavelength;
      noise[i] += amplitude * value_noise({c * x - s * y, s * x + c * y, 0.5}, key);
    }
    amplitude *= terrain.roughness;
    wavelength *= 0.5;
  }
  const auto [lo, hi] = std::minmax_element(noise.begin(), noise.end());
  if (!(*hi > *lo)) return;
  const double low = *lo, scale = terrain.relief_m / (*hi - *lo);
  for (std::size_t i = 0; i < vertices.size(); ++i) vertices[i].z() += (noise[i] - low - 0.5 * (*hi - low)) * scale;
}

TriangleMesh fractal_mesh(const Terrain& terrain) {
  const Vec2 extent = terrain.max - terrain.min;
  const auto columns = static_cast<std::size_t>(std::max(1.0, std::ceil(extent.x() / terrain.cell_m - 1e-9)));
  const auto rows = static_cast<std::size_t>(std::max(1.0, std::ceil(extent.y() / terrain.cell_m - 1e-9)));
  TriangleMesh mesh;
  mesh.vertices.reserve((columns + 1) * (rows + 1));
  for (std::size_t r = 0; r <= rows; ++r)
    for (std::size_t c = 0; c <= columns; ++c) {
      const double x = terrain.min.x() + extent.x() * static_cast<double>(c) / static_cast<double>(columns);
      const double y = terrain.min.y() + extent.y() * static_cast<double>(r) / static_cast<double>(rows);
      mesh.vertices.emplace_back(x, y, terrain.base_up_m + terrain.slope_east * x + terrain.slope_north * y);
    }
  if (terrain.relief_m > 0.0) add_noise(terrain, mesh.vertices);
  mesh.triangles.reserve(2 * columns * rows);
  for (std::size_t r = 0; r < rows; ++r)
    for (std::size_t c = 0; c < columns; ++c) {
      const auto sw = static_cast<std::uint32_t>(r * (columns + 1) + c);
      const std::uint32_t se = sw + 1, nw = sw + static_cast<std::uint32_t>(columns) + 1, ne = nw + 1;
      const auto step = [&](std::uint32_t a, std::uint32_t b) {
        return std::abs(mesh.vertices[a].z() - mesh.vertices[b].z());
      };
      if (step(sw, ne) <= step(se, nw)) {
        mesh.triangles.push_back({sw, se, ne});
        mesh.triangles.push_back({sw, ne, nw});
      } else {
        mesh.triangles.push_back({sw, se, nw});
        mesh.triangles.push_back({se, ne, nw});
      }
    }
  return mesh;
}

}  // namespace

TriangleMesh terrain_mesh(const Terrain& terrain) {
  switch (terrain.kind) {
    case TerrainKind::grid: return geometry::grid_mesh(terrain.heights).mesh;
    case TerrainKind::mesh: return terrain.mesh;
    case TerrainKind::fractal: break;
  }
  return fractal_mesh(terrain);
}

Ground::Ground(const TriangleMesh& mesh) : mesh_(&mesh), bounds_(mesh.bounds()), scene_(mesh) {}

std::vector<double> Ground::heights(std::span<const Vec2> places) const {
  const double top = bounds_.max.z() + 1.0;
  std::vector<geometry::Ray> rays(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) rays[i] = {{places[i].x(), places[i].y(), top}, -Vec3::UnitZ()};
  const auto hits = scene_.cast(rays);
  std::vector<double> result(places.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < places.size(); ++i)
    if (hits[i].hit()) result[i] = top - hits[i].distance;
  return result;
}

std::optional<double> Ground::height(const Vec2& place) const {
  const double up = heights(std::span(&place, 1))[0];
  return std::isnan(up) ? std::nullopt : std::optional(up);
}

std::optional<Vec3> Ground::normal(const Vec2& place) const {
  const geometry::Ray ray{{place.x(), place.y(), bounds_.max.z() + 1.0}, -Vec3::UnitZ()};
  const auto hit = scene_.cast(std::span(&ray, 1))[0];
  if (!hit.hit()) return std::nullopt;
  const Vec3 area = mesh_->area_vector(hit.triangle);
  return area.z() < 0.0 ? Vec3(-area.normalized()) : Vec3(area.normalized());
}

double Ground::mean_height(const geometry::Ring& area) const {
  double inside_sum = 0.0, all_sum = 0.0;
  std::size_t inside = 0;
  for (const Vec3& v : mesh_->vertices) {
    all_sum += v.z();
    if (!geometry::contains(area, v.head<2>())) continue;
    inside_sum += v.z();
    ++inside;
  }
  return inside > 0 ? inside_sum / static_cast<double>(inside) : all_sum / static_cast<double>(mesh_->vertices.size());
}

}  // namespace cairn::simulation
