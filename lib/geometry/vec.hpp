// Vector and matrix names used everywhere. Points and directions are double, metres.
#pragma once

#include <Eigen/Core>

namespace cairn::geometry {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Mat2 = Eigen::Matrix2d;
using Mat3 = Eigen::Matrix3d;

}  // namespace cairn::geometry
