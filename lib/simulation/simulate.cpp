#include "simulation/simulate.hpp"

#include <cmath>
#include <cstdio>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "simulation/detector.hpp"
#include "simulation/flight.hpp"
#include "simulation/ground.hpp"
#include "simulation/material.hpp"
#include "simulation/object_boxes.hpp"
#include "simulation/placement.hpp"
#include "simulation/pose_noise.hpp"

namespace cairn::simulation {
namespace {

constexpr std::size_t kMaxFrames = 10'000'000;

std::string image_name(std::size_t id, const Products& products) {
  if (!products.images) return "";
  char name[64];
  std::snprintf(name, sizeof(name), "images/%06zu.%s", id, products.image_format.c_str());
  return name;
}

std::vector<std::vector<SeenBox>> true_boxes(const Scene& scene, const std::vector<Exposure>& exposures,
                                             const std::vector<PlacedObject>& objects, const Obstruction& obstruction,
                                             base::RunContext& ctx) {
  std::vector<ObjectOutline> outlines;
  outlines.reserve(objects.size());
  for (const PlacedObject& object : objects) outlines.emplace_back(object.exposed);
  std::vector<std::vector<SeenBox>> boxes(exposures.size());
  base::parallel_for(exposures.size(), 32, [&](std::size_t begin, std::size_t end) {
    ctx.check_stop();
    for (std::size_t i = begin; i < end; ++i) {
      const auto& camera = scene.cameras[exposures[i].camera];
      const auto& T = exposures[i].T_world_camera;
      for (std::size_t k = 0; k < objects.size(); ++k) {
        const auto outline = outlines[k].seen(camera, T);
        if (!outline) continue;
        SeenBox box;
        box.truth.frame = survey::FrameId(static_cast<std::int64_t>(i) + 1);
        box.truth.object = objects[k].truth.id;
        box.truth.box = outline->box;
        box.truth.whole = outline->whole;
        box.truth.visible_share = obstruction.visible_share(k, outlines[k], camera, T);
        box.inside_share = outline->inside_share;
        if (box.truth.visible_share > 0.0) boxes[i].push_back(box);
      }
    }
  });
  return boxes;
}

survey::Manifest manifest(const Scene& scene, std::uint64_t seed) {
  survey::Manifest m;
  m.name = scene.name;
  m.origin = {scene.origin, survey::HeightType::ellipsoidal, ""};
  m.time_base = base::TimeBase::boot;
  m.cameras = scene.cameras;
  m.notes.push_back("Simulated from scene '" + scene.name + "' with seed " + std::to_string(seed) +
                    "; truth.json holds what was true");
  return m;
}

void add_frames(const Scene& scene, std::uint64_t seed, const std::vector<Exposure>& exposures, Recording& recording) {
  std::vector<double> times;
  std::vector<geometry::RigidTransform> poses;
  for (const Exposure& e : exposures) {
    times.push_back(e.time_s);
    poses.push_back(e.T_world_camera);
  }
  const auto noisy = noisy_poses(scene.pose_noise, seed, times, poses);
  for (std::size_t i = 0; i < exposures.size(); ++i) {
    survey::Frame frame;
    frame.id = survey::FrameId(static_cast<std::int64_t>(i) + 1);
    frame.time_ns = static_cast<std::int64_t>(std::llround((kFirstFrame_s + times[i]) * 1e9));
    frame.camera = scene.cameras[exposures[i].camera].id;
    frame.image = image_name(i + 1, scene.products);
    frame.T_world_camera = poses[i];
    recording.truth.frames.push_back(frame);
    frame.T_world_camera = noisy[i].T_world_camera;
    frame.sigma_xy_m = noisy[i].sigma_xy_m;
    frame.sigma_z_m = noisy[i].sigma_z_m;
    frame.sigma_rot_deg = noisy[i].sigma_rot_deg;
    recording.survey.frames.push_back(std::move(frame));
    recording.circled.push_back(exposures[i].circled);
  }
}

geometry::TriangleMesh checked_terrain(const Scene& scene) {
  validate(scene);
  auto mesh = terrain_mesh(scene.terrain);
  if (mesh.triangles.empty())
    throw base::Error(base::ErrorCode::failed_precondition, "the terrain has no surface").record("terrain");
  return mesh;
}

// The flights again and again, at most this often.
constexpr int kMostRounds = 1000;

std::vector<Exposure> flown_until(const Scene& scene, double least_duration_s, const Ground& ground,
                                  const std::vector<PlacedObject>& objects) {
  Scene rounds = scene;
  auto exposures = fly(rounds, ground, objects);
  for (int round = 1; !exposures.empty() && exposures.back().time_s < least_duration_s && round < kMostRounds;
       round *= 2) {
    const auto flights = rounds.flights;
    for (auto flight : flights) {
      flight.record_transit = true;
      rounds.flights.push_back(std::move(flight));
    }
    exposures = fly(rounds, ground, objects);
  }
  std::erase_if(exposures, [&](const Exposure& e) { return e.time_s > least_duration_s; });
  return exposures;
}

std::vector<Exposure> checked_flight(const Scene& scene, double least_duration_s, const Ground& ground,
                                     const std::vector<PlacedObject>& objects) {
  auto exposures =
      least_duration_s > 0.0 ? flown_until(scene, least_duration_s, ground, objects) : fly(scene, ground, objects);
  if (exposures.empty())
    throw base::Error(base::ErrorCode::failed_precondition, "no frame is taken on these flights").record("flights");
  if (exposures.size() > kMaxFrames)
    throw base::Error(base::ErrorCode::failed_precondition, "the flights take too many frames")
        .found(std::to_string(exposures.size()))
        .allowed("at most " + std::to_string(kMaxFrames));
  return exposures;
}

}  // namespace

struct Rehearsal::Impl {
  Impl(const Scene& s, double least_duration_s, base::RunContext& ctx)
      : scene(s),
        terrain(checked_terrain(s)),
        ground(terrain),
        objects(place_objects(s, ground)),
        exposures(checked_flight(s, least_duration_s, ground, objects)),
        obstruction(terrain, objects),
        boxes(true_boxes(s, exposures, objects, obstruction, ctx)) {}

  const Scene& scene;
  geometry::TriangleMesh terrain;
  Ground ground;
  std::vector<PlacedObject> objects;
  std::vector<Exposure> exposures;
  Obstruction obstruction;
  std::vector<std::vector<SeenBox>> boxes;  // of each exposure
};

Rehearsal::Rehearsal(const Scene& scene, base::RunContext& ctx, double least_duration_s)
    : impl_(std::make_unique<Impl>(scene, least_duration_s, ctx)) {}
Rehearsal::~Rehearsal() = default;
Rehearsal::Rehearsal(Rehearsal&&) noexcept = default;
Rehearsal& Rehearsal::operator=(Rehearsal&&) noexcept = default;

const Scene& Rehearsal::scene() const {
  return impl_->scene;
}
const geometry::TriangleMesh& Rehearsal::terrain() const {
  return impl_->terrain;
}
const Ground& Rehearsal::ground() const {
  return impl_->ground;
}
const std::vector<PlacedObject>& Rehearsal::objects() const {
  return impl_->objects;
}
const std::vector<Exposure>& Rehearsal::exposures() const {
  return impl_->exposures;
}
const Obstruction& Rehearsal::obstruction() const {
  return impl_->obstruction;
}

Recording Rehearsal::record(std::uint64_t seed) const {
  const Scene& scene = impl_->scene;
  Recording recording;
  add_frames(scene, seed, impl_->exposures, recording);
  auto found = detect(scene, seed, impl_->exposures, impl_->boxes, impl_->objects,
                      place_clutter(scene, seed, impl_->ground), impl_->obstruction);
  recording.survey.manifest = manifest(scene, seed);
  recording.survey.detections = std::move(found.detections);
  recording.terrain = impl_->terrain;
  recording.truth.scene = scene.name;
  recording.truth.seed = seed;
  recording.truth.detections = std::move(found.origins);
  for (const auto& frame : impl_->boxes)
    for (const SeenBox& box : frame) recording.truth.boxes.push_back(box.truth);
  for (const PlacedObject& object : impl_->objects) {
    recording.truth.objects.push_back(object.truth);
    recording.shapes.push_back(object.shape);
    recording.names.push_back(object.name);
    recording.specs.push_back(object.spec);
  }
  return recording;
}

std::vector<RenderBody> render_bodies(const Scene& scene, const Recording& recording) {
  std::vector<RenderBody> bodies;
  RenderBody ground;
  ground.mesh = recording.terrain;
  ground.material = *material_named(scene.terrain.material, scene.terrain.seed);
  ground.part = SurfacePart::terrain;
  bodies.push_back(std::move(ground));
  for (std::size_t i = 0; i < recording.shapes.size(); ++i) {
    const ObjectSpec& spec = scene.objects[recording.specs[i]];
    const ShapeKind kind = spec.shape.kind;
    const std::string usual = kind == ShapeKind::tree ? "foliage" : kind == ShapeKind::cone ? "paint" : "granite";
    RenderBody body;
    body.mesh = recording.shapes[i].body;
    body.material = *material_named(spec.material.empty() ? usual : spec.material, i + 1);
    body.part = kind == ShapeKind::tree || kind == ShapeKind::cone ? SurfacePart::other : SurfacePart::rock;
    body.object = recording.truth.objects[i].id.value;
    body.contact_rim = recording.shapes[i].contact_rim;
    RenderBody pedestal;
    pedestal.mesh = recording.shapes[i].pedestal;
    pedestal.material = body.material;
    pedestal.part = SurfacePart::pedestal;
    bodies.push_back(std::move(body));
    if (!pedestal.mesh.triangles.empty()) bodies.push_back(std::move(pedestal));
  }
  return bodies;
}

Recording simulate(const Scene& scene, std::uint64_t seed, base::RunContext& ctx) {
  return Rehearsal(scene, ctx).record(seed);
}

}  // namespace cairn::simulation
