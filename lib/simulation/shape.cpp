#include "simulation/shape.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/rigid_transform.hpp"
#include "simulation/noise.hpp"
#include "simulation/resting_body.hpp"

namespace cairn::simulation {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Mat3;
using geometry::RigidTransform;
using geometry::TriangleMesh;
using geometry::Vec3;

constexpr std::array<std::string_view, 8> kNames = {"sphere", "ellipsoid", "box",  "cylinder",
                                                    "cone",   "rock",      "tree", "mesh"};

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void require(bool holds, std::string_view field, double value, std::string_view allowed) {
  if (holds) return;
  throw Error(ErrorCode::invalid_argument, "the shape's " + std::string(field) + " is out of range")
      .found(base::to_text(value))
      .allowed(std::string(allowed));
}

void check(const ShapeSpec& spec) {
  for (int i = 0; i < 3; ++i) {
    const bool given_mesh = spec.kind == ShapeKind::mesh && spec.size_m[i] == 0.0;
    require(given_mesh || (spec.size_m[i] > 0.0 && spec.size_m[i] <= 1000.0), "size_m", spec.size_m[i],
            "above 0, at most 1000 m");
  }
  require(std::isfinite(spec.azimuth_deg), "azimuth_deg", spec.azimuth_deg, "a finite number");
  require(spec.tilt_deg >= 0.0 && spec.tilt_deg <= 45.0, "tilt_deg", spec.tilt_deg, "0 to 45");
  require(spec.irregularity >= 0.0 && spec.irregularity <= 1.0, "irregularity", spec.irregularity, "0 to 1");
  require(spec.pedestal_height_m >= 0.0 && spec.pedestal_height_m <= 100.0, "pedestal_height_m", spec.pedestal_height_m,
          "0 to 100 m");
  require(spec.pedestal_radius_m >= 0.0 && spec.pedestal_radius_m <= 100.0, "pedestal_radius_m", spec.pedestal_radius_m,
          "0 to 100 m");
  require(spec.foot_share == 0.0 || (spec.foot_share >= 0.1 && spec.foot_share <= 0.9), "foot_share", spec.foot_share,
          "0 (drawn), or 0.1 to 0.9");
  require(spec.contact_share > 0.0 && spec.contact_share <= 1.0, "contact_share", spec.contact_share,
          "above 0, at most 1");
  require(spec.contact_pads >= 1 && spec.contact_pads <= 5, "contact_pads", spec.contact_pads, "1 to 5");
  require(spec.contact_gap_m >= 0.0 && spec.contact_gap_m <= 0.1, "contact_gap_m", spec.contact_gap_m, "0 to 0.1 m");
  require(spec.edge_m >= 0.0 && std::isfinite(spec.edge_m), "edge_m", spec.edge_m, "0 (chosen), or more");
  const bool rock = spec.kind == ShapeKind::rock, tree = spec.kind == ShapeKind::tree;
  const auto& families = rock ? rock_families() : tree_families();
  if ((rock || tree) && !spec.family.empty() &&
      std::find(families.begin(), families.end(), spec.family) == families.end())
    throw Error(ErrorCode::invalid_argument, "the shape's family is not known")
        .found(spec.family)
        .allowed(joined(families));
}

RestingBody make_body(const ShapeSpec& spec, base::Random& random) {
  const double longest = spec.size_m.maxCoeff() > 0.0 ? spec.size_m.maxCoeff() : 1.0;
  const double edge = spec.edge_m > 0.0 ? std::max(spec.edge_m, longest / 2000.0) : longest / 50.0;
  if (spec.kind == ShapeKind::rock) return make_rock(spec, edge, random);
  if (spec.kind == ShapeKind::tree) return make_tree(spec, edge, random);
  return make_solid(spec, edge);
}

// Own axes -> world axes about the foot: the top leans towards +x, then x turns to the azimuth.
Mat3 turn(const ShapeSpec& spec) {
  const double a = base::deg_to_rad(spec.azimuth_deg);
  Mat3 to_azimuth;
  to_azimuth << std::sin(a), -std::cos(a), 0.0, std::cos(a), std::sin(a), 0.0, 0.0, 0.0, 1.0;
  return to_azimuth * geometry::axis_rotation(Vec3::UnitY(), base::deg_to_rad(spec.tilt_deg));
}

double lowest(const std::vector<Vec3>& points) {
  double z = points.front().z();
  for (const Vec3& p : points) z = std::min(z, p.z());
  return z;
}

// The seat inside and a little beyond the rim, then a weathered shoulder and a flank that widens downwards.
TriangleMesh make_pedestal(const RestingBody& body, const RigidTransform& place, const ShapeSpec& spec, double edge,
                           std::uint64_t seed) {
  const std::size_t n = body.sectors;
  const Vec3 middle = body.seat(0, 0.0);
  std::vector<double> rim(n);
  double mean = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    rim[i] = (body.seat(i, 1.0) - middle).head<2>().norm();
    mean += rim[i] / static_cast<double>(n);
  }
  const double wanted = spec.pedestal_radius_m > 0.0 ? spec.pedestal_radius_m : 1.3 * mean;
  const auto wander = [&](std::size_t i, double level, double frequency) {
    const double a = 2.0 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    return fractal_noise({frequency * std::cos(a), frequency * std::sin(a), 2.0 * level}, seed, 4);
  };
  std::vector<Ring3> rings;
  const auto inner = static_cast<std::size_t>(std::clamp(std::ceil(mean / edge), 3.0, 2000.0));
  for (std::size_t k = 1; k <= inner; ++k) {
    Ring3 ring(n);
    for (std::size_t i = 0; i < n; ++i)
      ring[i] = place * body.seat(i, static_cast<double>(k) / static_cast<double>(inner));
    rings.push_back(std::move(ring));
  }
  // The shoulder stands at least a fifteenth beyond the rim; the seat's own surface reaches it.
  std::vector<double> shoulder(n);
  for (std::size_t i = 0; i < n; ++i)
    shoulder[i] = std::max(wanted * (1.0 + 0.18 * spec.irregularity * wander(i, 0.0, 1.2)), 1.07 * rim[i] + 0.01);
  const auto outer = static_cast<std::size_t>(std::clamp(std::ceil((wanted - mean) / edge), 2.0, 2000.0));
  for (std::size_t k = 1; k <= outer; ++k) {
    Ring3 ring(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double t = static_cast<double>(k) / static_cast<double>(outer);
      ring[i] = place * body.seat(i, 1.0 + t * (shoulder[i] / rim[i] - 1.0));
    }
    rings.push_back(std::move(ring));
  }
  const Ring3 top = rings.back();
  const Vec3 centre = place * middle;
  const double drop = centre.z() + kPedestalDepth;
  const auto flank = static_cast<std::size_t>(std::clamp(std::ceil(drop / edge), 6.0, 2000.0));
  for (std::size_t k = 1; k <= flank; ++k) {
    const double t = static_cast<double>(k) / static_cast<double>(flank);
    Ring3 ring(n);
    for (std::size_t i = 0; i < n; ++i) {
      const Vec3 out = (top[i] - centre).cwiseProduct(Vec3(1.0, 1.0, 0.0)).normalized();
      const double bulge = 0.22 * wanted * std::sqrt(t) + 0.35 * drop * t * t;
      const double relief =
          0.1 * wanted * (0.3 + spec.irregularity) * wander(i, t * drop, 2.5) * std::min(1.0, 6.0 * t);
      const double z = top[i].z() + (-kPedestalDepth - top[i].z()) * std::pow(t, 1.25);
      ring[i] = top[i] + std::max(0.0, bulge + relief) * out;
      ring[i].z() = z;
    }
    rings.push_back(std::move(ring));
  }
  return ring_mesh(centre, rings, {centre.x(), centre.y(), -kPedestalDepth});
}

}  // namespace

std::string_view name_of(ShapeKind kind) {
  return kNames[static_cast<std::size_t>(kind)];
}

std::optional<ShapeKind> shape_kind_from(std::string_view name) {
  const auto* found = std::find(kNames.begin(), kNames.end(), name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<ShapeKind>(found - kNames.begin());
}

const std::vector<std::string>& rock_families() {
  static const std::vector<std::string> names = {"rounded", "angular", "slab", "pear", "stacked"};
  return names;
}

const std::vector<std::string>& tree_families() {
  static const std::vector<std::string> names = {"broadleaf", "conifer", "bush"};
  return names;
}

Shape make_shape(const ShapeSpec& spec, base::Random& random) {
  check(spec);
  RestingBody resting = make_body(spec, random);
  const std::uint64_t pedestal_seed = random.bits();
  RigidTransform place{turn(spec), Vec3::Zero()};
  std::vector<Vec3> feet;
  const bool seated = spec.pedestal_height_m > 0.0 && !resting.rim.empty();
  for (const Vec3& v : seated ? resting.rim.front() : resting.body.vertices) feet.push_back(place * v);
  const Vec3 middle = place * resting.seat(0, 0.0);
  place.translation = Vec3(-middle.x(), -middle.y(), spec.pedestal_height_m - lowest(feet));

  Shape shape;
  shape.family = resting.family;
  shape.body = std::move(resting.body);
  for (Vec3& v : shape.body.vertices) v = place * v;
  for (const auto* rings : {&resting.rim, &resting.bearing})
    for (const Ring3& ring : *rings) {
      Ring3 placed;
      for (const Vec3& p : ring) placed.push_back(place * p);
      (rings == &resting.rim ? shape.contact_rim : shape.contact_bearing).push_back(std::move(placed));
    }
  if (spec.pedestal_height_m > 0.0) {
    const double longest = shape.body.bounds().size().maxCoeff();
    const double edge = spec.edge_m > 0.0 ? std::max(spec.edge_m, longest / 2000.0) : longest / 50.0;
    shape.pedestal = make_pedestal(resting, place, spec, edge, pedestal_seed);
  }
  const auto mass = geometry::mass_properties(shape.body);
  shape.volume_m3 = mass.volume;
  shape.centre_of_mass = mass.centre_of_mass;
  return shape;
}

TriangleMesh ring_mesh(const Vec3& top, const std::vector<Ring3>& rings, const Vec3& bottom) {
  TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(rings.front().size());
  mesh.vertices.push_back(top);
  for (const Ring3& ring : rings) mesh.vertices.insert(mesh.vertices.end(), ring.begin(), ring.end());
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(bottom);
  const auto at = [n](std::size_t ring, std::uint32_t i) { return 1 + static_cast<std::uint32_t>(ring) * n + i % n; };
  for (std::uint32_t i = 0; i < n; ++i) {
    mesh.triangles.push_back({0, at(0, i), at(0, i + 1)});
    for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
      mesh.triangles.push_back({at(r, i), at(r + 1, i), at(r + 1, i + 1)});
      mesh.triangles.push_back({at(r, i), at(r + 1, i + 1), at(r, i + 1)});
    }
    mesh.triangles.push_back({last, at(rings.size() - 1, i + 1), at(rings.size() - 1, i)});
  }
  return mesh;
}

Vec3 stretch_to(const TriangleMesh& mesh, const Vec3& size) {
  geometry::Box3 bounds;
  for (const Vec3& v : mesh.vertices) bounds.extend(v);
  Vec3 scale = Vec3::Ones();
  for (int i = 0; i < 3; ++i)
    if (size[i] > 0.0) scale[i] = size[i] / bounds.size()[i];
  return scale;
}

void append(TriangleMesh& mesh, const TriangleMesh& more) {
  mesh.colours.insert(mesh.colours.end(), more.colours.begin(), more.colours.end());
  const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& t : more.triangles) mesh.triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
}

}  // namespace cairn::simulation
