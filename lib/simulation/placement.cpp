#include "simulation/placement.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "geometry/enclosing_circle.hpp"

namespace cairn::simulation {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

constexpr int kScatterTries = 10'000;
constexpr double kBaseShare = 0.002;  // of the height: the part of a body that counts as its base

// Height of each vertex above the ground; +infinity where there is none.
std::vector<double> clearance(const std::vector<Vec3>& vertices, const Ground& ground) {
  std::vector<Vec2> places;
  places.reserve(vertices.size());
  for (const Vec3& v : vertices) places.emplace_back(v.head<2>());
  std::vector<double> result = ground.heights(places);
  for (std::size_t i = 0; i < result.size(); ++i)
    result[i] = std::isnan(result[i]) ? std::numeric_limits<double>::infinity() : vertices[i].z() - result[i];
  return result;
}

// Point of the edge at the ground's height; `above` is above it, `below` is not.
Vec3 crossing(Vec3 above, Vec3 below, const Ground& ground) {
  while ((above - below).norm() > 1e-4) {
    const Vec3 middle = 0.5 * (above + below);
    const auto up = ground.height(middle.head<2>());
    (!up || middle.z() > *up ? above : below) = middle;
  }
  return above;
}

void move(TriangleMesh& mesh, const Vec3& by) {
  for (Vec3& v : mesh.vertices) v += by;
}

void move(Shape& shape, const Vec3& by) {
  move(shape.body, by);
  move(shape.pedestal, by);
  for (auto* rings : {&shape.contact_rim, &shape.contact_bearing})
    for (auto& ring : *rings)
      for (Vec3& p : ring) p += by;
  shape.centre_of_mass += by;
}

// How far the shape, at its place but at height 0, goes up until no part of its base is above the ground. A pedestal
// reaches into the ground: its own foot, the shape's origin, lies on it.
double resting_height(const Shape& shape, const Ground& ground, const Vec2& place, const std::string& name) {
  std::vector<Vec3> base;
  const geometry::Box3 box = shape.body.bounds();
  if (!shape.pedestal.vertices.empty()) base.emplace_back(place.x(), place.y(), 0.0);
  else
    for (const Vec3& v : shape.body.vertices)
      if (v.z() <= box.min.z() + kBaseShare * box.size().z()) base.push_back(v);
  double up = std::numeric_limits<double>::infinity();
  for (const double c : clearance(base, ground)) up = std::min(up, -c);
  if (!std::isfinite(up))
    throw Error(ErrorCode::failed_precondition, "object '" + name + "' does not stand on the ground")
        .found("(" + base::to_text(place.x()) + ", " + base::to_text(place.y()) + ")")
        .hint("Place it inside the terrain, or give up_m");
  return up;
}

class Placer {
 public:
  Placer(const Scene& scene, const Ground& ground) : scene_(scene), ground_(ground) {}

  std::vector<PlacedObject> place() {
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
      const ObjectSpec& spec = scene_.objects[i];
      if (spec.scatter) scatter(spec, i);
      else put(spec, spec.shape, *spec.position, i, 0);
    }
    return std::move(placed_);
  }

 private:
  void scatter(const ObjectSpec& spec, std::size_t index) {
    const Scatter& s = *spec.scatter;
    base::Random random(spec.seed, "simulation scatter", index);
    for (std::int64_t copy = 0; copy < s.count; ++copy) {
      int tries = 0;
      for (; tries < kScatterTries; ++tries) {
        const Vec2 place = random_point_in(s.area, random);
        if (!has_room(place, s.spacing_m)) continue;
        const auto normal = ground_.normal(place);
        if (!normal || std::acos(std::min(1.0, normal->z())) > base::deg_to_rad(s.max_slope_deg)) continue;
        ShapeSpec shape = spec.shape;
        const double share = random.uniform(s.size_share_lo, s.size_share_hi);
        shape.size_m *= share;
        shape.pedestal_height_m *= share;
        shape.pedestal_radius_m *= share;
        shape.azimuth_deg = random.uniform(0.0, 360.0);
        put(spec, shape, place, index, copy);
        break;
      }
      if (tries == kScatterTries)
        throw Error(ErrorCode::failed_precondition, "no room for a scattered object")
            .record("objects[" + std::to_string(index) + "].scatter")
            .found(std::to_string(copy) + " of " + std::to_string(s.count) + " placed")
            .hint("Lower count or spacing_m, enlarge the area, or raise max_slope_deg");
    }
  }

  // Cells of the size of the spacing asked for would vary between scatters: a plain map of 1 m cells serves.
  [[nodiscard]] bool has_room(const Vec2& place, double spacing) const {
    const auto reach = static_cast<std::int64_t>(std::ceil(spacing));
    const auto cx = static_cast<std::int64_t>(std::floor(place.x())),
               cy = static_cast<std::int64_t>(std::floor(place.y()));
    for (std::int64_t y = cy - reach; y <= cy + reach; ++y) {
      for (auto it = taken_.lower_bound({y, cx - reach}); it != taken_.end() && it->first <= std::pair(y, cx + reach);
           ++it)
        if ((it->second - place).norm() < spacing) return false;
    }
    return true;
  }

  void put(const ObjectSpec& spec, const ShapeSpec& shape_spec, const Vec2& place, std::size_t index,
           std::int64_t copy) {
    PlacedObject object;
    object.truth.id = survey::ObjectId(static_cast<std::int64_t>(placed_.size()) + 1);
    object.truth.object_class = spec.object_class;
    object.truth.sought = spec.sought;
    object.spec = index;
    object.name = spec.name.empty() ? spec.object_class + " " + std::to_string(object.truth.id.value) : spec.name;
    const std::string& name = object.name;
    base::Random random(spec.seed, "simulation shape " + std::to_string(index), static_cast<std::uint64_t>(copy));
    object.shape = shape_of(shape_spec, random, index);
    move(object.shape, {place.x(), place.y(), 0.0});
    const double up = spec.up_m ? *spec.up_m : resting_height(object.shape, ground_, place, name);
    move(object.shape, {0.0, 0.0, up - spec.sink_m});
    object.exposed = exposed_part(object.shape.body, ground_);
    if (object.exposed.triangles.empty())
      throw Error(ErrorCode::failed_precondition, "object '" + name + "' lies wholly below the ground")
          .hint("Raise up_m or lower sink_m");
    measure(object);
    taken_.emplace(
        std::pair(static_cast<std::int64_t>(std::floor(place.y())), static_cast<std::int64_t>(std::floor(place.x()))),
        place);
    placed_.push_back(std::move(object));
  }

  // A spec out of range is a fault of the scene.
  static Shape shape_of(const ShapeSpec& spec, base::Random& random, std::size_t index) {
    try {
      return make_shape(spec, random);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::invalid_argument) throw;
      throw Error(ErrorCode::failed_precondition, error.message())
          .record("objects[" + std::to_string(index) + "].shape " + error.record())
          .found(error.found())
          .allowed(error.allowed())
          .hint(error.hint());
    }
  }

  static void measure(PlacedObject& object) {
    std::vector<Vec2> plan;
    geometry::Box3 box;
    for (const Vec3& v : object.exposed.vertices) {
      plan.emplace_back(v.head<2>());
      box.extend(v);
    }
    const auto circle = geometry::smallest_enclosing_circle(plan);
    object.truth.cylinder = {circle.centre, box.min.z(), box.max.z(), circle.radius};
    object.truth.contact_rim = object.shape.contact_rim;
    object.truth.contact_bearing = object.shape.contact_bearing;
    object.truth.volume_m3 = object.shape.volume_m3;
    object.truth.centre_of_mass = object.shape.centre_of_mass;
  }

  const Scene& scene_;
  const Ground& ground_;
  std::vector<PlacedObject> placed_;
  std::multimap<std::pair<std::int64_t, std::int64_t>, Vec2> taken_;
};

}  // namespace

TriangleMesh exposed_part(const TriangleMesh& mesh, const Ground& ground) {
  const std::vector<double> height = clearance(mesh.vertices, ground);
  TriangleMesh result;
  std::vector<std::int64_t> index(mesh.vertices.size(), -1);
  const auto keep = [&](std::uint32_t v) {
    if (index[v] < 0) {
      index[v] = static_cast<std::int64_t>(result.vertices.size());
      result.vertices.push_back(mesh.vertices[v]);
    }
    return static_cast<std::uint32_t>(index[v]);
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> cuts;
  const auto cut = [&](std::uint32_t above, std::uint32_t below) {
    const auto [it, fresh] = cuts.try_emplace({above, below}, static_cast<std::uint32_t>(result.vertices.size()));
    if (fresh) result.vertices.push_back(crossing(mesh.vertices[above], mesh.vertices[below], ground));
    return it->second;
  };
  for (const geometry::Triangle& t : mesh.triangles) {
    std::vector<std::uint32_t> polygon;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      if (height[a] > 0.0) polygon.push_back(keep(a));
      if ((height[a] > 0.0) != (height[b] > 0.0)) polygon.push_back(height[a] > 0.0 ? cut(a, b) : cut(b, a));
    }
    for (std::size_t k = 2; k < polygon.size(); ++k)
      result.triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
  }
  return result;
}

Vec2 random_point_in(const geometry::Ring& area, base::Random& random) {
  Vec2 lo = area[0], hi = area[0];
  for (const Vec2& p : area) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  Vec2 p = lo;
  // A simple polygon of area > 0 fills some share of its box.
  for (int tries = 0; tries < 100'000; ++tries) {
    p = {random.uniform(lo.x(), hi.x()), random.uniform(lo.y(), hi.y())};
    if (geometry::contains(area, p)) break;
  }
  return p;
}

std::vector<PlacedObject> place_objects(const Scene& scene, const Ground& ground) {
  return Placer(scene, ground).place();
}

}  // namespace cairn::simulation
