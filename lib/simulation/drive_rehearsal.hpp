// A scene with a ground vehicle in it: all that does not depend on what the vehicle does.
#pragma once

#include <cstdint>
#include <vector>

#include "simulation/range_scanner.hpp"
#include "simulation/simulate.hpp"
#include "simulation/vehicle_contact.hpp"
#include "survey/detection.hpp"
#include "survey/ground_vehicle.hpp"
#include "visibility/scene.hpp"

namespace cairn::simulation {

class DriveRehearsal {
 public:
  // The flights are repeated until scene.drive->limit_s. The scene must outlive this. Throws as Rehearsal, and
  // invalid_argument where the scene has no drive, failed_precondition where the vehicle's start or goal is in contact
  // with an object or off the ground.
  DriveRehearsal(const Scene& scene, base::RunContext& ctx);

  [[nodiscard]] const Rehearsal& flown() const { return flown_; }
  [[nodiscard]] const DriveSpec& drive() const { return *flown_.scene().drive; }
  [[nodiscard]] const VehicleContact& contact() const { return contact_; }
  [[nodiscard]] double mean_up() const { return mean_up_; }  // of the ground inside drive().area, local up, m

  // True state at a place: height and slope of the ground under it give z, roll and pitch.
  struct Pose {
    geometry::Vec3 position = geometry::Vec3::Zero();  // of the body's foot, local ENU, m
    double yaw = 0.0;                                  // counter-clockwise from east, rad
  };
  // Off the ground the height is that of the ground's mean.
  [[nodiscard]] Pose standing(const geometry::Vec2& place, double yaw) const;

  // What the detector makes of the vehicle in exposure `index` when it stands at `pose`: at most one detection (ids
  // and frame are not set) and its true box; misses are drawn anew for each frame. Confusions of its class apply.
  struct Sighting {
    std::vector<survey::TruthBox> truth;       // object and frame are not set
    std::vector<survey::Detection> detection;  // id and frame are not set
  };
  [[nodiscard]] Sighting sight(std::size_t index, const Pose& pose, std::uint64_t seed) const;

  // One turn of the scanner on the vehicle, against terrain and objects.
  [[nodiscard]] survey::RangeScan scan(const Pose& pose, const geometry::Vec2& velocity, double yaw_rate,
                                       std::int64_t time_ns, base::Random& random) const;

 private:
  Rehearsal flown_;
  VehicleContact contact_;
  visibility::Scene solids_;
  double mean_up_ = 0.0;
};

// The vehicle's body at a pose: a block of 12 triangles, closed and outward, local ENU.
[[nodiscard]] geometry::TriangleMesh vehicle_mesh(const VehicleBody& body, const DriveRehearsal::Pose& pose);

}  // namespace cairn::simulation
