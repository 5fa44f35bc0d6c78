#include "pipeline/ground_aircraft.hpp"

#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "io/survey_folder.hpp"

namespace cairn::pipeline {

GroundAircraft::GroundAircraft(const simulation::DriveRehearsal& rehearsal, const AircraftOptions& options,
                               std::uint64_t seed)
    : rehearsal_(rehearsal), options_(options), seed_(seed), all_(rehearsal.flown().record(seed)) {
  // What is sent is what `cairn obstacles` makes of the recorded tables.
  for (auto* frames : {&all_.survey.frames, &all_.truth.frames})
    for (auto& frame : *frames) frame.T_world_camera = io::exact_pose(frame.T_world_camera);
  const auto& drive = rehearsal.drive();
  const auto standing = rehearsal.standing(drive.start, 0.0);
  survey::TruthObject vehicle;
  vehicle.id = vehicle_ = survey::ObjectId(static_cast<std::int64_t>(all_.truth.objects.size()) + 1);
  vehicle.object_class = drive.body.object_class;
  const double up = standing.position.z();
  vehicle.cylinder = {drive.start, up, up + drive.body.height_m,
                      0.5 * std::hypot(drive.body.length_m, drive.body.width_m)};
  vehicle.volume_m3 = drive.body.length_m * drive.body.width_m * drive.body.height_m;
  vehicle.centre_of_mass = standing.position + geometry::Vec3(0.0, 0.0, 0.5 * drive.body.height_m);
  kept_ = all_;
  kept_.truth.objects.push_back(vehicle);
  for (auto* frames : {&kept_.survey.frames, &kept_.truth.frames}) frames->clear();
  kept_.survey.detections.clear();
  kept_.truth.boxes.clear();
  kept_.truth.detections.clear();
  kept_.circled.clear();
}

double GroundAircraft::next_s() const {
  const auto& exposures = rehearsal_.flown().exposures();
  return frame_ < exposures.size() ? exposures[frame_].time_s : std::numeric_limits<double>::infinity();
}

void GroundAircraft::take(const survey::Detection& detection, survey::ObjectId object, std::int64_t clutter) {
  survey::Detection record = detection;
  record.id = survey::DetectionId(static_cast<std::int64_t>(kept_.survey.detections.size()) + 1);
  record.frame = all_.survey.frames[frame_].id;
  kept_.truth.detections.push_back({record.id, object, clutter});
  kept_.survey.detections.push_back(std::move(record));
}

survey::Packet GroundAircraft::expose(const simulation::DriveRehearsal::Pose& pose) {
  const survey::Frame& frame = all_.survey.frames[frame_];
  kept_.survey.frames.push_back(frame);
  kept_.truth.frames.push_back(all_.truth.frames[frame_]);
  kept_.circled.push_back(all_.circled[frame_]);
  const std::size_t first = kept_.survey.detections.size();
  for (; detection_ < all_.survey.detections.size() && all_.survey.detections[detection_].frame == frame.id;
       ++detection_) {
    const auto& origin = all_.truth.detections[detection_];
    take(all_.survey.detections[detection_], origin.object, origin.clutter);
  }
  for (; box_ < all_.truth.boxes.size() && all_.truth.boxes[box_].frame == frame.id; ++box_)
    kept_.truth.boxes.push_back(all_.truth.boxes[box_]);
  auto sighting = rehearsal_.sight(frame_, pose, seed_);
  for (auto& box : sighting.truth) {
    box.frame = frame.id;
    box.object = vehicle_;
    kept_.truth.boxes.push_back(box);
  }
  for (const auto& detection : sighting.detection) take(detection, vehicle_, -1);
  const auto detections = std::span(kept_.survey.detections).subspan(first);
  const auto& camera = *all_.survey.camera(frame.camera);
  auto made = ground::make_packet(detections, frame, camera, {}, options_.classes, options_.projection,
                                  static_cast<std::uint32_t>(frame_ + 1));
  ++frame_;
  return std::move(made.packet);
}

simulation::Recording GroundAircraft::recording() && {
  return std::move(kept_);
}

}  // namespace cairn::pipeline
