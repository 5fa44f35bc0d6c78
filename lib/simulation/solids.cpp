#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "simulation/resting_body.hpp"

namespace cairn::simulation {
namespace {

using geometry::Triangle;
using geometry::TriangleMesh;
using geometry::Vec3;

constexpr double kTurn = 2.0 * std::numbers::pi;

Ring3 ellipse(std::size_t sectors, double rx, double ry, double z) {
  Ring3 ring(sectors);
  for (std::size_t i = 0; i < sectors; ++i) {
    const double a = kTurn * static_cast<double>(i) / static_cast<double>(sectors);
    // Exact where the ring meets the axes, so that the extents are.
    const double c = 4 * i == sectors || 4 * i == 3 * sectors ? 0.0 : std::cos(a);
    const double s = i == 0 || 2 * i == sectors ? 0.0 : std::sin(a);
    ring[i] = {rx * c, ry * s, z};
  }
  return ring;
}

std::size_t sectors_for(double around, double edge) {
  return static_cast<std::size_t>(4.0 * std::clamp(std::ceil(around / edge / 4.0), 4.0, 2000.0));
}

// Latitudes and longitudes; vertices on the ellipsoid.
TriangleMesh ellipsoid(const Vec3& size, double edge) {
  const std::size_t sectors = sectors_for(std::numbers::pi * 0.5 * (size.x() + size.y()), edge);
  const std::size_t rings = sectors / 2;
  std::vector<Ring3> stack;
  for (std::size_t k = 1; k < rings; ++k) {
    const double polar = std::numbers::pi * static_cast<double>(k) / static_cast<double>(rings);
    const double s = 2 * k == rings ? 1.0 : std::sin(polar), c = 2 * k == rings ? 0.0 : std::cos(polar);
    stack.push_back(ellipse(sectors, 0.5 * size.x() * s, 0.5 * size.y() * s, 0.5 * size.z() * (1.0 + c)));
  }
  return ring_mesh({0.0, 0.0, size.z()}, stack, Vec3::Zero());
}

Ring3 shrunk(const Ring3& ring, double factor) {
  Ring3 inner = ring;
  for (Vec3& p : inner) p.head<2>() *= factor;
  return inner;
}

// Flat-based bodies: the rim is the outline of the base, the bearing ring the same drawn in.
void rest_on(RestingBody& solid, Ring3 rim, double contact_share) {
  solid.bearing.push_back(contact_share >= 1.0 ? rim : shrunk(rim, std::sqrt(contact_share)));
  solid.sectors = rim.size();
  solid.seat = [rim](std::size_t i, double factor) {
    return Vec3(factor * rim[i].x(), factor * rim[i].y(), rim[i].z());
  };
  solid.rim.push_back(std::move(rim));
}

// Outline of the base of a box with some points a side, so that a pedestal can follow it.
Ring3 rectangle(double hx, double hy) {
  constexpr int kPerSide = 16;
  const Vec3 corners[4] = {{-hx, -hy, 0.0}, {hx, -hy, 0.0}, {hx, hy, 0.0}, {-hx, hy, 0.0}};
  Ring3 ring;
  for (std::size_t side = 0; side < 4; ++side)
    for (int k = 0; k < kPerSide; ++k)
      ring.push_back(corners[side] + (corners[(side + 1) % 4] - corners[side]) * (k / static_cast<double>(kPerSide)));
  return ring;
}

TriangleMesh box(const Vec3& size) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(((i & 1U) != 0 ? 0.5 : -0.5) * size.x(), ((i & 2U) != 0 ? 0.5 : -0.5) * size.y(),
                               (i & 4U) != 0 ? size.z() : 0.0);
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

Vec3 filled_in(const Vec3& wanted, const Vec3& found) {
  double ratio = 1.0;
  int given = 0;
  for (int i = 0; i < 3; ++i)
    if (wanted[i] > 0.0) {
      if (given++ == 0) ratio = wanted[i] / found[i];
    }
  Vec3 size;
  for (int i = 0; i < 3; ++i) size[i] = wanted[i] > 0.0 ? wanted[i] : ratio * found[i];
  return size;
}

TriangleMesh given_mesh(const ShapeSpec& spec) {
  TriangleMesh mesh = spec.mesh;
  if (mesh.triangles.empty())
    throw base::Error(base::ErrorCode::invalid_argument, "a shape of kind mesh needs a mesh with triangles");
  const auto state = geometry::topology(mesh);
  if (!state.closed())
    throw base::Error(base::ErrorCode::invalid_argument, "the mesh of a shape is not closed and oriented")
        .found(std::to_string(state.boundary_edges) + " open and " + std::to_string(state.inconsistent_edges) +
               " inconsistent edges")
        .hint("cairn surface closes a mesh");
  const auto bounds = mesh.bounds();
  const Vec3 middle(bounds.centre().x(), bounds.centre().y(), bounds.min.z());
  for (Vec3& v : mesh.vertices) v -= middle;
  const Vec3 found = bounds.size();
  if (!(found.minCoeff() > 0.0)) throw base::Error(base::ErrorCode::invalid_argument, "the mesh of a shape is flat");
  const Vec3 scale = filled_in(spec.size_m, found).cwiseQuotient(found);
  for (Vec3& v : mesh.vertices) v = v.cwiseProduct(scale);
  return mesh;
}

// A cone with the orange and white of the road, for whoever draws it.
TriangleMesh traffic_cone(const Vec3& size, std::size_t sectors) {
  constexpr std::array<std::uint8_t, 3> kOrange = {232, 92, 28}, kWhite = {236, 236, 232};
  constexpr double kSharp = 0.002;  // of the height, over which the colour changes
  std::vector<Ring3> rings;
  std::vector<bool> white;
  const auto add = [&](double z, bool is_white) {
    rings.push_back(ellipse(sectors, 0.5 * size.x() * (1.0 - z), 0.5 * size.y() * (1.0 - z), z * size.z()));
    white.push_back(is_white);
  };
  for (const auto& [top, bottom] : {std::pair{0.8, 0.62}, std::pair{0.45, 0.25}}) {
    add(top + kSharp, false);
    add(top, true);
    add(bottom, true);
    add(bottom - kSharp, false);
  }
  add(0.0, false);
  TriangleMesh mesh = ring_mesh({0.0, 0.0, size.z()}, rings, Vec3::Zero());
  mesh.colours.assign(mesh.vertices.size(), kOrange);
  for (std::size_t r = 0; r < rings.size(); ++r)
    if (white[r]) std::fill_n(mesh.colours.begin() + static_cast<std::ptrdiff_t>(1 + r * sectors), sectors, kWhite);
  return mesh;
}

}  // namespace

RestingBody make_solid(const ShapeSpec& spec, double edge) {
  RestingBody solid;
  const Vec3& size = spec.size_m;
  const double rx = 0.5 * size.x(), ry = 0.5 * size.y();
  const std::size_t sectors = sectors_for(std::numbers::pi * (rx + ry), edge);
  switch (spec.kind) {
    case ShapeKind::box:
      solid.body = box(size);
      rest_on(solid, rectangle(rx, ry), spec.contact_share);
      solid.rim.front() = {solid.body.vertices[0], solid.body.vertices[1], solid.body.vertices[3],
                           solid.body.vertices[2]};
      break;
    case ShapeKind::cylinder: {
      const Ring3 base = ellipse(sectors, rx, ry, 0.0);
      solid.body = ring_mesh({0.0, 0.0, size.z()}, {ellipse(sectors, rx, ry, size.z()), base}, Vec3::Zero());
      rest_on(solid, base, spec.contact_share);
      break;
    }
    case ShapeKind::cone: {
      const Ring3 base = ellipse(sectors, rx, ry, 0.0);
      solid.body = traffic_cone(size, sectors);
      rest_on(solid, base, spec.contact_share);
      break;
    }
    case ShapeKind::mesh: solid.body = given_mesh(spec); break;
    default: solid.body = ellipsoid(size, edge); break;
  }
  if (!solid.seat) {
    const Vec3 extent = solid.body.bounds().size();
    const Ring3 under = ellipse(64, 0.25 * extent.x(), 0.25 * extent.y(), 0.0);
    solid.sectors = under.size();
    solid.seat = [under](std::size_t i, double factor) { return Vec3(factor * under[i]); };
  }
  return solid;
}

}  // namespace cairn::simulation
