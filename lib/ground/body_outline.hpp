// The box that an upright body of revolution fills in an image, and the body that fills a box.
#pragma once

#include <array>
#include <optional>

#include "geometry/primitives.hpp"
#include "geometry/rigid_transform.hpp"
#include "ground/class_table.hpp"
#include "ground/ground_height.hpp"
#include "survey/camera.hpp"

namespace cairn::ground {

struct UprightBody {
  Shape shape = Shape::cylinder;
  geometry::Vec3 foot = geometry::Vec3::Zero();  // middle of the base, local ENU, m
  double width_m = 1.0, height_m = 1.0;          // > 0
};

// Outline box with the lens model; may reach beyond the image. Empty where a part of the body cannot be projected.
// Each level circle is sampled every 15 deg with a parabola through the extreme: error below 1e-4 of the radius.
[[nodiscard]] std::optional<geometry::PixelBox> outline_box(const UprightBody& body, const survey::Camera& camera,
                                                            const geometry::RigidTransform& T_world_camera);

// Sigmas of what the fit takes as given.
struct FitNoise {
  std::array<double, 4> edge_px{};  // xmin, ymin, xmax, ymax; infinity = the edge is not used
  double position_xy_m = 0.0, position_z_m = 0.0, rotation = 0.0, ground_m = 0.0;  // rotation: rad, each axis
};

struct BodyFit {
  UprightBody body;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();  // of east, north [m], log width, log height
};

// See projector.hpp. slope_base: m. start: foot, width and height to start from. Empty where it does not converge.
[[nodiscard]] std::optional<BodyFit> fit_body(const geometry::PixelBox& box, const survey::Camera& camera,
                                              const geometry::RigidTransform& T_world_camera, const Ground& ground,
                                              const ObjectModel& model, const FitNoise& noise, double slope_base,
                                              const UprightBody& start);

}  // namespace cairn::ground
