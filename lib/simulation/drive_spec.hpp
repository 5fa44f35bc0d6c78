// A ground vehicle (UGV) that drives through a scene while the aircraft flies: paper B's demonstrations.
// docs/formats/scene.md is the text form.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"

namespace cairn::simulation {

// Body of the vehicle: a block, as the aircraft sees it and as it collides.
struct VehicleBody {
  std::string object_class = "ugv";  // what a perfect detector calls it
  double length_m = 0.508;           // along its forward axis, > 0; with the width a Clearpath Jackal's
  double width_m = 0.43;             // > 0
  double height_m = 0.5;             // with the scanner on top, > 0
};

// 2-D range scanner, level, at the vehicle's centre. Defaults: paper B's UTM-30LX at a coarser step.
struct ScannerSpec {
  double height_m = 0.3;         // above the ground, > 0: below the tip of a cone
  double rate_hz = 10.0;         // turns a second, > 0
  double turn_s = 0.01875;       // from the first to the last ray, 0..1/rate
  double field_deg = 270.0;      // of view about the forward axis, 0 < f <= 360
  double step_deg = 0.5;         // between rays, > 0
  double range_min_m = 0.1;      // > 0
  double range_max_m = 30.0;     // > range_min_m
  double sigma_m = 0.02;         // of a range, >= 0
  double dropout_share = 0.002;  // of rays without a measurement (NaN), 0..1
};

// Errors of the vehicle's inertial log (simulation/inertial_log.hpp).
struct InertialSpec {
  double rate_hz = 50.0;             // B3
  double velocity_noise_m_s = 0.05;  // sigma of one axis, each record
  double velocity_bias_m_s = 0.02;   // sigma of one axis of the slowly drifting bias
  double heading_deg = 1.0;          // sigma of the heading
};

struct DriveSpec {
  geometry::Vec2 start = geometry::Vec2::Zero(), goal = geometry::Vec2::Zero();  // local east, north, m
  double heading_deg = 90.0;                                                     // at the start, clockwise from north
  double start_s = 0.0;           // after the aircraft's start the vehicle waits this long, s, >= 0
  double limit_s = 300.0;         // the run ends here at the latest, s, > start_s
  double goal_tolerance_m = 0.4;  // > 0
  std::string link = "football";  // delays of the radio link: football or park (B15, B16)
  VehicleBody body;
  ScannerSpec scanner;
  InertialSpec inertial;
  // Ground that the vehicle may use, and what its prior map holds as blocked (B13); local east, north, m.
  geometry::Ring area;
  std::vector<geometry::Ring> prior_blocked;
};

// Throws invalid_argument naming the member ("drive.scanner.rate_hz"), its value and what is allowed.
void validate(const DriveSpec& drive);

}  // namespace cairn::simulation
