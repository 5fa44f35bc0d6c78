// What a ground vehicle must not drive into.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "geometry/vec.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

// Paper B, B4: trees are seen but ignored (the vehicle passes below the crown).
enum class ObstacleKind { obstacle, ignored, vehicle };

[[nodiscard]] std::string_view name_of(ObstacleKind kind);

struct Obstacle {
  TargetId target;
  std::string object_class;
  ObstacleKind kind = ObstacleKind::obstacle;
  geometry::Vec3 position = geometry::Vec3::Zero();    // foot of the object, local ENU, m
  geometry::Mat2 covariance = geometry::Mat2::Zero();  // of east and north, m^2
  double width_m = 0.0;                                // diameter of the smallest upright cylinder
  double height_m = 0.0;
  double score = 0.0;
  std::size_t observations = 0;
  std::size_t misses = 0;          // images that showed its place and not it, since it was last seen
  std::int64_t first_seen_ns = 0;  // capture times on the survey's time base; 0 = not known
  std::int64_t last_seen_ns = 0;
  double sigma_width_m = 0.0;   // 0 = not known
  double sigma_height_m = 0.0;  // 0 = not known
  // Set where the object moves: east and north, m/s, with its covariance, m^2/s^2. `position` then holds at
  // last_seen_ns.
  std::optional<geometry::Vec2> velocity;
  geometry::Mat2 velocity_covariance = geometry::Mat2::Zero();
};

}  // namespace cairn::survey
