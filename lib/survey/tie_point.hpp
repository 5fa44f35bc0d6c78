// A point seen in several images: the evidence that poses and intrinsics are right.
#pragma once

#include <vector>

#include "geometry/vec.hpp"
#include "survey/ids.hpp"

namespace cairn::survey {

struct TieObservation {
  FrameId frame;
  geometry::Vec2 pixel = geometry::Vec2::Zero();  // raw image, corner convention, px
};

struct TiePoint {
  TiePointId id;
  geometry::Vec3 p_world = geometry::Vec3::Zero();  // local ENU, m
  std::vector<TieObservation> observations;
};

}  // namespace cairn::survey
