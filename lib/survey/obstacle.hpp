// What a ground vehicle must not drive into.
#pragma once

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
};

}  // namespace cairn::survey
