#include "simulation/drive_rehearsal.hpp"

#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"
#include "simulation/detector.hpp"

namespace cairn::simulation {
namespace {

using geometry::TriangleMesh;
using geometry::Vec2;
using geometry::Vec3;

const Scene& with_drive(const Scene& scene) {
  if (!scene.drive)
    throw base::Error(base::ErrorCode::invalid_argument, "the scene has no ground vehicle")
        .record("drive")
        .hint("Add the member 'drive', or simulate without --drive");
  return scene;
}

void append(TriangleMesh& all, const TriangleMesh& part) {
  const auto first = static_cast<std::uint32_t>(all.vertices.size());
  all.vertices.insert(all.vertices.end(), part.vertices.begin(), part.vertices.end());
  for (const auto& t : part.triangles) all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
}

TriangleMesh solids(const Rehearsal& flown) {
  TriangleMesh all;
  append(all, flown.terrain());
  for (const PlacedObject& object : flown.objects()) {
    append(all, object.shape.body);
    append(all, object.shape.pedestal);
  }
  return all;
}

}  // namespace

TriangleMesh vehicle_mesh(const VehicleBody& body, const DriveRehearsal::Pose& pose) {
  const Vec3 ahead(0.5 * body.length_m * std::cos(pose.yaw), 0.5 * body.length_m * std::sin(pose.yaw), 0.0);
  const Vec3 left(-0.5 * body.width_m * std::sin(pose.yaw), 0.5 * body.width_m * std::cos(pose.yaw), 0.0);
  const Vec3 up(0.0, 0.0, body.height_m);
  TriangleMesh mesh;
  for (const Vec3& level : {Vec3(Vec3::Zero()), up})
    for (const Vec3& corner : {Vec3(-ahead - left), Vec3(ahead - left), Vec3(ahead + left), Vec3(left - ahead)})
      mesh.vertices.emplace_back(pose.position + corner + level);
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                    {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  return mesh;
}

DriveRehearsal::DriveRehearsal(const Scene& scene, base::RunContext& ctx)
    : flown_(with_drive(scene), ctx, scene.drive->limit_s),
      contact_(flown_.objects(), scene.drive->body),
      solids_(solids(flown_)) {
  mean_up_ = flown_.ground().mean_height(drive().area);
  for (const auto& [name, place] : {std::pair("start", drive().start), std::pair("goal", drive().goal)}) {
    if (!flown_.ground().height(place))
      throw base::Error(base::ErrorCode::failed_precondition, "the vehicle does not stand on the ground")
          .record(std::string("drive.") + name);
    const auto nearest = contact_.nearest(place, 0.0);
    if (nearest.distance_m < 0.5 * drive().body.width_m)
      throw base::Error(base::ErrorCode::failed_precondition, "an object stands where the vehicle should")
          .record(std::string("drive.") + name)
          .found(flown_.objects()[nearest.object].name + " at " + base::to_fixed(nearest.distance_m, 2) + " m")
          .allowed("at least half the vehicle's width");
  }
}

DriveRehearsal::Pose DriveRehearsal::standing(const Vec2& place, double yaw) const {
  return {{place.x(), place.y(), flown_.ground().height(place).value_or(mean_up_)}, yaw};
}

DriveRehearsal::Sighting DriveRehearsal::sight(std::size_t index, const Pose& pose, std::uint64_t seed) const {
  const Scene& scene = flown_.scene();
  const Exposure& exposure = flown_.exposures().at(index);
  const auto& camera = scene.cameras[exposure.camera];
  const ObjectOutline outline(vehicle_mesh(drive().body, pose));
  const auto seen = outline.seen(camera, exposure.T_world_camera);
  Sighting result;
  if (!seen) return result;
  std::size_t free = 0, facing = 0;
  for (const auto& sample : outline.samples()) {
    const Vec3 way = exposure.T_world_camera.translation - sample.point;
    if (way.dot(sample.normal) <= 0.0) continue;
    ++facing;
    free += flown_.obstruction().free(exposure.T_world_camera.translation, sample.point) ? 1U : 0U;
  }
  SeenBox box;
  box.truth.object = survey::ObjectId(1);
  box.truth.frame = survey::FrameId(1);
  box.truth.box = seen->box;
  box.truth.whole = seen->whole;
  box.truth.visible_share = facing > 0 ? static_cast<double>(free) / static_cast<double>(facing) : 1.0;
  box.inside_share = seen->inside_share;
  if (!(box.truth.visible_share > 0.0)) return result;
  result.truth.push_back(box.truth);

  PlacedObject vehicle;
  vehicle.truth.id = box.truth.object;
  vehicle.truth.object_class = drive().body.object_class;
  Scene alone;
  alone.detector = scene.detector;
  alone.detector.clutter.clear();
  alone.detector.false_per_image = 0.0;
  alone.confusions = scene.confusions;
  alone.cameras = {camera};
  Exposure single = exposure;
  single.camera = 0;
  const std::uint64_t frame_seed = base::Random(seed, "simulation vehicle sightings", index).bits();
  auto found = detect(alone, frame_seed, {single}, {{box}}, {vehicle}, {}, flown_.obstruction());
  result.detection = std::move(found.detections);
  return result;
}

survey::RangeScan DriveRehearsal::scan(const Pose& pose, const Vec2& velocity, double yaw_rate, std::int64_t time_ns,
                                       base::Random& random) const {
  const ScannerMotion motion{pose.position + Vec3(0.0, 0.0, drive().scanner.height_m), pose.yaw, velocity, yaw_rate};
  return simulation::scan(solids_, drive().scanner, motion, time_ns, random);
}

}  // namespace cairn::simulation
