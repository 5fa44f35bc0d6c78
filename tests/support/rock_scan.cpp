#include "support/rock_scan.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include "base/angle.hpp"
#include "base/random.hpp"
#include "base/run_context.hpp"
#include "geometry/kd_tree.hpp"
#include "simulation/ground.hpp"
#include "simulation/placement.hpp"
#include "simulation/render_scene.hpp"
#include "simulation/sampled_cloud.hpp"
#include "simulation/scene.hpp"

namespace cairn::testing {
namespace {

using geometry::Vec2;
using geometry::Vec3;
using simulation::ObjectSpec;
using simulation::PlacedObject;
using simulation::ShapeKind;
using simulation::SurfacePart;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr std::uint32_t kNoTarget = 0xffffffffU;

std::string drawn_family(base::Random& random) {
  std::vector<std::string> families;
  for (const auto& name : simulation::rock_families())
    if (name != kHeldOutFamily) families.push_back(name);
  return families[random.below(families.size())];
}

// Length, width and height of a rock of this height.
Vec3 drawn_size(double height, base::Random& random) {
  const double length = height * random.uniform(0.62, 1.05);
  return {length, length * random.uniform(0.7, 1.0), height};
}

void draw_contact(simulation::ShapeSpec& shape, const RockScanOptions& options, base::Random& random) {
  const bool several = random.uniform() < 0.2;
  const int pads = several ? 2 + static_cast<int>(random.below(3)) : 1;
  shape.contact_pads = options.contact_pads > 0 ? options.contact_pads : pads;
  const double share = shape.contact_pads > 1 ? random.uniform(0.15, 0.4)
                                              : std::min(1.0, random.uniform(0.45, 1.1));  // one in six: the rim bears
  shape.contact_share = options.contact_share > 0.0 ? options.contact_share : share;
  shape.contact_gap_m = random.uniform(0.003, 0.02);
}

simulation::Scene patch(std::uint64_t seed, double half, base::Random& random) {
  simulation::Scene scene;
  scene.terrain.min = Vec2::Constant(-half);
  scene.terrain.max = Vec2::Constant(half);
  scene.terrain.cell_m = 0.05;
  const double slope = std::tan(base::deg_to_rad(random.uniform(0.0, 10.0))), towards = random.uniform(0.0, kTurn);
  scene.terrain.slope_east = slope * std::cos(towards);
  scene.terrain.slope_north = slope * std::sin(towards);
  scene.terrain.relief_m = random.uniform(0.1, 0.4);
  scene.terrain.wavelength_m = 3.0;
  scene.terrain.roughness = 0.45;
  scene.terrain.seed = seed;
  return scene;
}

simulation::RenderScene rendered(const simulation::Scene& scene, const geometry::TriangleMesh& ground,
                                 const std::vector<PlacedObject>& objects) {
  std::vector<simulation::RenderBody> bodies(1);
  bodies[0].mesh = ground;
  bodies[0].material = *simulation::material_named("gravel", scene.terrain.seed);
  bodies[0].part = SurfacePart::terrain;
  for (const PlacedObject& object : objects) {
    const bool rock = scene.objects[object.spec].shape.kind == ShapeKind::rock;
    simulation::RenderBody body;
    body.mesh = object.shape.body;
    body.material = *simulation::material_named(rock ? "granite" : "foliage", 1);
    body.part = rock ? SurfacePart::rock : SurfacePart::other;
    body.object = object.truth.id.value;
    body.contact_rim = object.shape.contact_rim;
    simulation::RenderBody pedestal = body;
    bodies.push_back(std::move(body));
    if (object.shape.pedestal.triangles.empty()) continue;
    pedestal.mesh = object.shape.pedestal;
    pedestal.part = SurfacePart::pedestal;
    pedestal.contact_rim.clear();
    bodies.push_back(std::move(pedestal));
  }
  simulation::Lighting lighting;
  lighting.openness_rays = 8;
  return {std::move(bodies), lighting};
}

survey::Camera phone() {
  survey::Camera camera;
  camera.id = survey::CameraId(1);
  camera.width_px = 4000;
  camera.height_px = 3000;
  camera.fx_px = camera.fy_px = 2900.0;
  camera.cx_px = 2000.0;
  camera.cy_px = 1500.0;
  return camera;
}

simulation::View look(const Vec3& eye, const Vec3& at) {
  simulation::View view;
  view.camera = phone();
  const Vec3 forward = (at - eye).normalized();
  const Vec3 right = forward.cross(Vec3::UnitZ()).normalized();
  view.T_world_camera.rotation.col(0) = right;
  view.T_world_camera.rotation.col(1) = forward.cross(right);
  view.T_world_camera.rotation.col(2) = forward;
  view.T_world_camera.translation = eye;
  return view;
}

// Rings about the rock: a person's eye held low at the contact, standing, and a pole or a drone above.
std::vector<simulation::View> rings_of_views(const RockScan& scan, const simulation::Ground& ground,
                                             base::Random& random, double missing_from, double missing_width) {
  const double height = scan.cylinder.height();
  const Vec3 foot(scan.cylinder.axis.x(), scan.cylinder.axis.y(), scan.cylinder.bottom);
  struct Ring {
    double above_foot, distance, aim;
    int count;
  };
  const std::array<Ring, 3> rings = {
      Ring{random.uniform(0.05, 0.35), scan.cylinder.radius + random.uniform(1.4, 2.2), 0.35 * height, 24},
      Ring{0.7 * height + 0.4, scan.cylinder.radius + random.uniform(2.0, 3.0), 0.45 * height, 20},
      Ring{1.4 * height + 1.2, scan.cylinder.radius + random.uniform(1.2, 2.2), 0.5 * height, 14}};
  std::vector<simulation::View> views;
  for (const Ring& ring : rings)
    for (int i = 0; i < ring.count; ++i) {
      const double a = kTurn * (i + random.uniform(-0.25, 0.25)) / ring.count;
      const double from_gap = std::remainder(a - missing_from - 0.5 * missing_width, kTurn);
      if (missing_width > 0.0 && std::abs(from_gap) < 0.5 * missing_width) continue;
      Vec3 eye = foot + Vec3(ring.distance * std::cos(a), ring.distance * std::sin(a), ring.above_foot);
      const double floor = ground.height(eye.head<2>()).value_or(foot.z() - 1.0) + 0.15;
      eye.z() = std::max(eye.z(), floor);
      views.push_back(look(eye, foot + Vec3(0.0, 0.0, ring.aim)));
    }
  return views;
}

// Top of the pedestal or of the ground at a place of the plan.
double foothold(const RockScan& scan, const simulation::Ground& ground, const Vec2& place) {
  constexpr double kNear = 0.04;  // m, of the pedestal's vertices
  double up = ground.height(place).value_or(0.0);
  for (const Vec3& v : scan.pedestal.vertices)
    if ((v.head<2>() - place).norm() < kNear) up = std::max(up, v.z());
  return up;
}

// Shrubs just outside the rim over a sector of it, on the pedestal or before it, that reach above the contact.
void add_brush(simulation::Scene& scene, const RockScan& scan, const simulation::Ground& ground, base::Random& random) {
  const auto& rim = scan.rim.front();
  const double first = random.uniform(0.0, kTurn);
  const int count = 2 + static_cast<int>(random.below(3));
  for (int i = 0; i < count; ++i) {
    const double a = first + i * random.uniform(0.35, 0.9);
    const auto k = static_cast<std::size_t>(std::fmod(a / kTurn, 1.0) * static_cast<double>(rim.size()));
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : rim) middle += p / static_cast<double>(rim.size());
    const Vec3 out = (rim[k] - middle).cwiseProduct(Vec3(1.0, 1.0, 0.0)).normalized();
    const double radius = random.uniform(0.12, 0.22);
    ObjectSpec shrub;
    shrub.object_class = "shrub";
    shrub.shape.kind = ShapeKind::tree;
    shrub.shape.family = "bush";
    const Vec2 place = rim[k].head<2>() + (radius + random.uniform(0.0, 0.06)) * out.head<2>();
    const double foot = foothold(scan, ground, place) - 0.05;
    shrub.shape.size_m = Vec3(2.0 * radius, 2.0 * radius, rim[k].z() - foot + random.uniform(0.12, 0.35));
    shrub.shape.edge_m = 0.02;
    shrub.position = place;
    shrub.up_m = foot;
    shrub.seed = random.bits();
    scene.objects.push_back(shrub);
  }
}

double share_hidden(const RockScan& scan) {
  std::vector<Vec3> rock, pedestal;
  geometry::Box3 box;
  for (const auto& ring : scan.rim)
    for (const Vec3& p : ring) box.extend(p);
  const double reach = 3.0 * scan.spacing_m;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Vec3& p = scan.cloud.positions[i];
    if ((p.array() < box.min.array() - reach).any() || (p.array() > box.max.array() + reach).any()) continue;
    if (scan.surface[i] == 2) rock.push_back(p);
    if (scan.surface[i] == 3) pedestal.push_back(p);
  }
  if (rock.empty() || pedestal.empty()) return 1.0;
  const geometry::KdTree of_rock(rock), of_pedestal(pedestal);
  double length = 0.0, hidden = 0.0;
  const auto near = [&](const geometry::KdTree& tree, const Vec3& p) {
    return tree.nearest(p, 1).front().squared_distance <= reach * reach;
  };
  for (const auto& ring : scan.rim)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec3 &a = ring[i], &b = ring[(i + 1) % ring.size()];
      const Vec3 middle = 0.5 * (a + b);
      length += (b - a).norm();
      if (!near(of_rock, middle) || !near(of_pedestal, middle)) hidden += (b - a).norm();
    }
  return length > 0.0 ? hidden / length : 1.0;
}

std::vector<Vec3> all_points(const std::vector<std::vector<Vec3>>& rings) {
  std::vector<Vec3> points;
  for (const auto& ring : rings) points.insert(points.end(), ring.begin(), ring.end());
  return points;
}

double alpha_deg(const fragility::TippingResult& result) {
  return result.critical ? base::rad_to_deg(result.edges[*result.critical].alpha) : 0.0;
}

double distance_to_rings(const Vec3& p, const std::vector<std::vector<Vec3>>& rings) {
  double best = 1e300;
  for (const auto& ring : rings)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec3 &a = ring[i], &b = ring[(i + 1) % ring.size()];
      const double length = (b - a).squaredNorm();
      const double t = length > 0.0 ? std::clamp((p - a).dot(b - a) / length, 0.0, 1.0) : 0.0;
      best = std::min(best, (p - a - t * (b - a)).squaredNorm());
    }
  return std::sqrt(best);
}

std::vector<std::uint8_t> as_bytes(const std::vector<double>& values) {
  std::vector<std::uint8_t> result;
  for (const double v : values) result.push_back(static_cast<std::uint8_t>(v));
  return result;
}

std::vector<std::uint32_t> as_ids(const std::vector<double>& values) {
  std::vector<std::uint32_t> result;
  for (const double v : values) result.push_back(static_cast<std::uint32_t>(v));
  return result;
}

geometry::PointCloud with_columns(geometry::PointCloud cloud, const std::vector<std::uint8_t>& label,
                                  const std::vector<std::uint32_t>& target_id) {
  cloud.add_scalar("label", geometry::ScalarType::u8, "0 none 1 terrain 2 rock 3 pedest 4 contact")
      .values.assign(label.begin(), label.end());
  cloud.add_scalar("target_id", geometry::ScalarType::u32, "rock instance; 4294967295 none")
      .values.assign(target_id.begin(), target_id.end());
  return cloud;
}

void take_truth(RockScan& scan, const PlacedObject& object) {
  scan.body = object.shape.body;
  scan.pedestal = object.shape.pedestal;
  scan.rim = object.shape.contact_rim;
  scan.bearing = object.shape.contact_bearing;
  scan.cylinder = object.truth.cylinder;
  scan.family = object.shape.family;
  scan.mass = geometry::mass_properties(scan.body);
  scan.on_rim = fragility::tipping(scan.mass, all_points(scan.rim));
  scan.on_bearing = fragility::tipping(scan.mass, all_points(scan.bearing));
}

void sample(RockScan& scan, const simulation::RenderScene& world, const std::vector<simulation::View>& views,
            const RockScanOptions& options) {
  simulation::CloudOptions how;
  how.spacing_m = options.spacing_m;
  how.noise_m = options.noise_m;
  how.outlier_share = options.outlier_share;
  how.margin_m = options.margin_m;
  how.contact_width_m = 1e-9;  // points keep their body; the basal contact is named below
  base::RunContext ctx;
  ctx.seed = options.sampling == 0 ? scan.seed : base::Random(scan.seed, "rock scan sampling", options.sampling).bits();
  scan.cloud = simulation::sample_cloud(world, views, how, ctx);
  scan.surface = as_bytes(scan.cloud.scalar("label")->values);
  scan.target_id = as_ids(scan.cloud.scalar("target_id")->values);
  scan.cloud.scalars.clear();
  scan.label = scan.surface;
  const double width = 1.5 * options.spacing_m;
  geometry::Box3 box;
  for (const Vec3& p : all_points(scan.rim)) box.extend(p);
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Vec3& p = scan.cloud.positions[i];
    if (scan.label[i] != 2 && scan.label[i] != 3) continue;
    if ((p.array() < box.min.array() - width).any() || (p.array() > box.max.array() + width).any()) continue;
    if (distance_to_rings(p, scan.rim) <= width) scan.label[i] = 4;
  }
}

}  // namespace

double RockScan::alpha_rim_deg() const {
  return alpha_deg(on_rim);
}

double RockScan::alpha_bearing_deg() const {
  return alpha_deg(on_bearing);
}

survey::Contact RockScan::contact(bool of_bearing) const {
  survey::Contact line;
  const auto& rings = of_bearing ? bearing : rim;
  for (std::size_t pad = 0; pad < rings.size(); ++pad)
    for (std::size_t i = 0; i < rings[pad].size(); ++i)
      line.push_back({static_cast<std::int64_t>(pad), static_cast<std::int64_t>(i), rings[pad][i], true, true, 0.0});
  return line;
}

geometry::PointCloud RockScan::labelled() const {
  return with_columns(cloud, label, target_id);
}

survey::Truth RockScan::truth() const {
  survey::Truth result;
  result.scene = "rock scan";
  result.seed = seed;
  survey::TruthObject object;
  object.id = survey::ObjectId(1);
  object.object_class = "pbr";
  object.sought = true;
  object.cylinder = cylinder;
  object.contact_rim = rim;
  object.contact_bearing = bearing;
  object.volume_m3 = mass.volume;
  object.centre_of_mass = mass.centre_of_mass;
  result.objects.push_back(std::move(object));
  return result;
}

RockScan make_rock_scan(std::uint64_t seed, const RockScanOptions& options) {
  base::Random random(seed, "rock scan", 0);
  RockScan scan;
  scan.seed = seed;
  scan.spacing_m = options.spacing_m;
  scan.noise_m = options.noise_m;
  const double height_drawn = random.uniform(0.8, 2.5), hiding_drawn = random.uniform();
  const std::string family_drawn = drawn_family(random);
  const double height = options.height_m > 0.0 ? options.height_m : height_drawn;
  scan.hiding = options.hiding;
  if (scan.hiding == Hiding::drawn)
    scan.hiding = hiding_drawn < 0.5 ? Hiding::none : hiding_drawn < 0.75 ? Hiding::brush : Hiding::sector;

  simulation::Scene scene = patch(seed, 1.3 * height + options.margin_m + 4.0, random);
  ObjectSpec rock;
  rock.object_class = "pbr";
  rock.seed = seed;
  rock.position = Vec2::Zero();
  rock.shape.kind = ShapeKind::rock;
  rock.shape.family = options.family.empty() ? family_drawn : options.family;
  rock.shape.size_m = drawn_size(height, random);
  rock.shape.azimuth_deg = random.uniform(0.0, 360.0);
  rock.shape.tilt_deg = random.uniform(0.0, 10.0);
  rock.shape.irregularity = random.uniform(0.25, 0.75);
  rock.shape.foot_share = random.uniform(0.35, 0.75);
  rock.shape.edge_m = options.edge_m;
  rock.shape.pedestal_height_m = random.uniform(0.12, 0.8);
  const double rim_radius = 0.25 * (rock.shape.size_m.x() + rock.shape.size_m.y()) * rock.shape.foot_share;
  rock.shape.pedestal_radius_m = rim_radius * random.uniform(1.15, 2.6);
  draw_contact(rock.shape, options, random);
  scene.objects.push_back(rock);

  const auto terrain = simulation::terrain_mesh(scene.terrain);
  const simulation::Ground ground(terrain);
  auto placed = simulation::place_objects(scene, ground);
  take_truth(scan, placed.front());
  if (scan.hiding == Hiding::brush) {
    add_brush(scene, scan, ground, random);
    placed = simulation::place_objects(scene, ground);
  }
  std::vector<simulation::View> views;
  if (scan.hiding != Hiding::absent) {
    const double from = random.uniform(0.0, kTurn), width = base::deg_to_rad(random.uniform(130.0, 220.0));
    views = rings_of_views(scan, ground, random, from, scan.hiding == Hiding::sector ? width : 0.0);
  }
  sample(scan, rendered(scene, terrain, placed), views, options);
  scan.hidden_share = share_hidden(scan);
  return scan;
}

namespace {

ObjectSpec scene_rock(const RockSceneOptions& options, bool pedestal, base::Random& random) {
  ObjectSpec rock;
  rock.object_class = "pbr";
  rock.sought = true;
  rock.shape.kind = ShapeKind::rock;
  const std::string drawn = drawn_family(random);
  rock.shape.family = options.family.empty() ? drawn : options.family;
  rock.shape.size_m = drawn_size(random.uniform(options.size_min_m, options.size_max_m), random);
  rock.shape.azimuth_deg = random.uniform(0.0, 360.0);
  rock.shape.irregularity = random.uniform(0.25, 0.75);
  rock.shape.foot_share = random.uniform(0.4, 0.8);
  rock.shape.edge_m = 0.04;
  rock.seed = random.bits();
  if (pedestal) {
    rock.shape.pedestal_height_m = random.uniform(0.15, 0.8);
    rock.shape.pedestal_radius_m = rock.shape.size_m.x() * random.uniform(0.3, 0.6);
  }
  return rock;
}

double least_distance(const geometry::TriangleMesh& a, const geometry::TriangleMesh& b, const Vec3& b_moved) {
  const geometry::KdTree tree(a.vertices);
  double best = 1e300;
  for (const Vec3& v : b.vertices) best = std::min(best, tree.nearest(v + b_moved, 1).front().squared_distance);
  return std::sqrt(best);
}

// Moves the second towards the first until they touch: within a third of an edge's length.
Vec2 touching_place(const PlacedObject& still, const PlacedObject& moved, double gap) {
  const Vec2 way = still.truth.cylinder.axis - moved.truth.cylinder.axis;
  double free = 0.0, touching = 1.0;
  for (int i = 0; i < 16; ++i) {
    const double middle = 0.5 * (free + touching);
    const Vec3 by(middle * way.x(), middle * way.y(), 0.0);
    (least_distance(still.shape.body, moved.shape.body, by) > gap ? free : touching) = middle;
  }
  return touching * way;
}

}  // namespace

geometry::PointCloud RockScene::labelled() const {
  return with_columns(cloud, label, target_id);
}

RockScene make_rock_scene(std::uint64_t seed, const RockSceneOptions& options) {
  base::Random random(seed, "rock scene", 0);
  RockScene result;
  result.seed = seed;
  const auto count = options.on_pedestals + options.on_ground + 2 * options.touching_pairs + options.shrubs;
  const double half = 0.5 * options.room_m * std::sqrt(static_cast<double>(count));
  simulation::Scene scene;
  scene.terrain.min = Vec2::Constant(-half - 3.0);
  scene.terrain.max = Vec2::Constant(half + 3.0);
  scene.terrain.cell_m = 0.1;
  scene.terrain.slope_east = options.slope * random.uniform(-1.0, 1.0);
  scene.terrain.slope_north = options.slope * random.uniform(-1.0, 1.0);
  scene.terrain.relief_m = options.relief_m;
  scene.terrain.wavelength_m = 15.0;
  scene.terrain.roughness = 0.45;
  scene.terrain.seed = seed;

  // Places on a jittered lattice, so that none of them touch unless meant to.
  const auto side = static_cast<std::int64_t>(std::ceil(std::sqrt(static_cast<double>(count))));
  std::vector<std::int64_t> cells(static_cast<std::size_t>(side * side));
  for (std::size_t i = 0; i < cells.size(); ++i) cells[i] = static_cast<std::int64_t>(i);
  for (std::size_t i = cells.size(); i > 1; --i) std::swap(cells[i - 1], cells[random.below(i)]);
  const auto place = [&](std::size_t k) {
    const double cell = 2.0 * half / static_cast<double>(side), jitter = 0.18 * cell;
    return Vec2(-half + cell * (static_cast<double>(cells[k] % side) + 0.5) + random.uniform(-jitter, jitter),
                -half + cell * (static_cast<double>(cells[k] / side) + 0.5) + random.uniform(-jitter, jitter));
  };
  std::size_t used = 0;
  const auto add = [&](ObjectSpec spec, const Vec2& at) {
    spec.position = at;
    scene.objects.push_back(std::move(spec));
  };
  for (std::int64_t i = 0; i < options.on_pedestals; ++i) add(scene_rock(options, true, random), place(used++));
  for (std::int64_t i = 0; i < options.on_ground; ++i) {
    ObjectSpec rock = scene_rock(options, false, random);
    rock.sink_m = random.uniform(0.0, 0.12) * rock.shape.size_m.z();
    add(std::move(rock), place(used++));
  }
  const std::size_t first_pair = scene.objects.size();
  for (std::int64_t i = 0; i < options.touching_pairs; ++i) {
    const Vec2 at = place(used++);
    const double a = random.uniform(0.0, kTurn);
    ObjectSpec one = scene_rock(options, false, random), other = scene_rock(options, false, random);
    const double reach = one.shape.size_m.x() + other.shape.size_m.x();
    add(std::move(one), at);
    add(std::move(other), at + reach * Vec2(std::cos(a), std::sin(a)));
  }
  for (std::int64_t i = 0; i < options.shrubs; ++i) {
    ObjectSpec shrub;
    shrub.object_class = "shrub";
    shrub.shape.kind = ShapeKind::tree;
    shrub.shape.family = "bush";
    const double size = random.uniform(0.4, 1.0);
    shrub.shape.size_m = Vec3(size, size, size * random.uniform(0.5, 0.9));
    shrub.shape.edge_m = 0.04;
    shrub.seed = random.bits();
    add(std::move(shrub), place(used++));
  }
  const auto terrain = simulation::terrain_mesh(scene.terrain);
  const simulation::Ground ground(terrain);
  auto placed = simulation::place_objects(scene, ground);
  for (std::int64_t i = 0; i < options.touching_pairs; ++i) {
    const std::size_t one = first_pair + 2 * static_cast<std::size_t>(i), other = one + 1;
    *scene.objects[other].position += touching_place(placed[one], placed[other], 0.3 * 0.04);
  }
  if (options.touching_pairs > 0) placed = simulation::place_objects(scene, ground);

  simulation::CloudOptions how;
  how.spacing_m = options.spacing_m;
  how.noise_m = options.noise_m;
  base::RunContext ctx;
  ctx.seed = seed;
  result.cloud = simulation::sample_cloud(rendered(scene, terrain, placed), {}, how, ctx);
  result.label = as_bytes(result.cloud.scalar("label")->values);
  result.target_id = as_ids(result.cloud.scalar("target_id")->values);
  result.cloud.scalars.clear();
  for (PlacedObject& object : placed) {
    if (scene.objects[object.spec].shape.kind != ShapeKind::rock) continue;
    result.rocks.push_back(std::move(object.truth));
    result.bodies.push_back(std::move(object.shape.body));
  }
  return result;
}

}  // namespace cairn::testing
