// What the aircraft sends to the ground vehicle: D_packet of paper B, equation (4), with what misprint E9 and gap table
// 6 of its reading add (both counts, sequence, covariance, class).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/primitives.hpp"
#include "geometry/vec.hpp"

namespace cairn::survey {

struct PacketObject {
  geometry::Vec3 position = geometry::Vec3::Zero();    // P_obj: foot, local ENU, m
  geometry::Mat2 covariance = geometry::Mat2::Zero();  // of east and north, m^2
  double size_m = 0.0;                                 // S_obj: width, m
  double height_m = 0.0;                               // 0 = not known
  std::string object_class;
  double score = 0.0;  // 0..1
};

struct PacketVehicle {
  geometry::Vec3 position = geometry::Vec3::Zero();    // P_ugv, local ENU, m
  geometry::Mat2 covariance = geometry::Mat2::Zero();  // of east and north, m^2
};

struct Packet {
  std::uint32_t sequence = 0;
  std::int64_t capture_time_ns = 0;  // when the image was taken (B9), on the survey's time base
  std::vector<PacketObject> objects;
  std::vector<PacketVehicle> vehicles;
  // Ground that the image showed, local ENU east and north, m; a simple polygon, empty = not sent. An object that was
  // known there and is in no packet any more is missing.
  geometry::Ring footprint;
};

struct ReceivedPacket {
  std::int64_t arrival_time_ns = 0;  // >= capture
  Packet packet;
};

}  // namespace cairn::survey
