#include "fragility/surface_moments.hpp"

#include <array>
#include <cmath>
#include <map>

namespace cairn::fragility {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

void SurfaceMoments::add(double weight, const Vec3& x) {
  area += weight;
  first += weight * x;
  second += weight * x * x.transpose();
}

void BodyMoments::add(double displacement, const SurfaceMoments& patch) {
  volume += displacement * patch.area;
  first += displacement * patch.first;
  second += displacement * patch.second;
}

std::vector<SurfaceMoments> surface_patches(const geometry::TriangleMesh& mesh, const Vec3& centre, double cell,
                                            std::span<const std::uint8_t> seen) {
  std::map<std::array<std::int64_t, 3>, SurfaceMoments> cells;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& tri = mesh.triangles[t];
    const double area = mesh.area_vector(t).norm();
    const std::array<Vec3, 3> p{mesh.vertices[tri[0]] - centre, mesh.vertices[tri[1]] - centre,
                                mesh.vertices[tri[2]] - centre};
    const Vec3 middle = (p[0] + p[1] + p[2]) / 3.0;
    std::array<std::int64_t, 3> key{};
    for (int i = 0; i < 3; ++i)
      key[static_cast<std::size_t>(i)] = static_cast<std::int64_t>(std::floor(middle[i] / cell));
    auto& patch = cells[key];
    // Edge midpoints integrate quadratics over a triangle exactly.
    for (std::size_t i = 0; i < 3; ++i) patch.add(area / 3.0, 0.5 * (p[i] + p[(i + 1) % 3]));
    if (!seen.empty() && seen[t] == 0) patch.unseen += area;
  }
  std::vector<SurfaceMoments> patches;
  patches.reserve(cells.size());
  for (const auto& [key, patch] : cells) patches.push_back(patch);
  return patches;
}

CapMoments cap_moments(const std::vector<ContactVertex>& contact, const Vec3& centre) {
  // Gauss-Legendre with three points on [0, 1], for the share rho of the way from the middle to the line.
  const double far = 0.5 * std::sqrt(0.6);
  const std::array<std::pair<double, double>, 3> gauss{
      {{0.5 - far, 5.0 / 18.0}, {0.5, 8.0 / 18.0}, {0.5 + far, 5.0 / 18.0}}};
  CapMoments cap;
  for (const auto& pad : pads_of(contact)) {
    const std::size_t count = pad.last - pad.first;
    if (count < 3) continue;
    const Vec3 middle = middle_of(contact, pad);
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3& a = contact[pad.first + k].position;
      const Vec3& b = contact[pad.first + (k + 1) % count].position;
      const Vec2 u = (a - middle).head<2>(), v = (b - middle).head<2>();
      // Signed, so that a fan that folds over itself still sums to the polygon's area.
      const double area = 0.5 * (u.x() * v.y() - u.y() * v.x());
      for (const auto& [rho, share] : gauss) {
        const double weight = share * 2.0 * rho * area, bump = 1.0 - rho * rho;
        const Vec3 x = middle + rho * (0.5 * (a + b) - middle) - centre;
        cap.level.add(weight, x);
        cap.bump.add(weight * bump, x);
        cap.bump_squared += weight * bump * bump;
      }
    }
  }
  if (cap.level.area < 0.0) {  // the line runs clockwise
    for (auto* m : {&cap.level, &cap.bump}) {
      m->area = -m->area;
      m->first = -m->first;
      m->second = -m->second;
    }
    cap.bump_squared = -cap.bump_squared;
  }
  return cap;
}

BodyMoments moments_of(const geometry::MassProperties& mass) {
  BodyMoments m;
  m.volume = mass.volume;
  m.second = 0.5 * mass.inertia_per_density.trace() * Mat3::Identity() - mass.inertia_per_density;
  return m;
}

geometry::MassProperties mass_of(const BodyMoments& moments, const Vec3& about, double area) {
  geometry::MassProperties mass;
  mass.volume = moments.volume;
  mass.area = area;
  const Vec3 offset = moments.first / moments.volume;
  mass.centre_of_mass = about + offset;
  const Mat3 second = moments.second - moments.volume * offset * offset.transpose();
  mass.inertia_per_density = second.trace() * Mat3::Identity() - second;
  return mass;
}

}  // namespace cairn::fragility
