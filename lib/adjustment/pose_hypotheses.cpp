#include "adjustment/pose_hypotheses.hpp"

#include <algorithm>
#include <string_view>

namespace cairn::adjustment {
namespace {

using geometry::Mat3;
using geometry::RigidTransform;
using geometry::Vec3;
using Order = PoseHypothesis::Order;
using Direction = PoseHypothesis::Direction;
using CameraAxes = PoseHypothesis::CameraAxes;
using WorldAxes = PoseHypothesis::WorldAxes;

struct Words {
  std::string_view code, meaning, remedy;
};

Words words(Order order) {
  if (order == Order::was_xyzw)
    return {"quaternion_order_xyzw", "the quaternions are stored x,y,z,w but were read as w,x,y,z",
            "name the quaternion columns in the order of the source (qx,qy,qz,qw) and import again"};
  return {"quaternion_order_wxyz", "the quaternions are stored w,x,y,z but were read as x,y,z,w",
          "name the quaternion columns in the order of the source (qw,qx,qy,qz) and import again"};
}

Words words(Direction direction) {
  switch (direction) {
    case Direction::inverted:
      return {"pose_inverted", "the poses are world-to-camera, given as camera-to-world",
              "invert the poses (R' = R^T, C = -R^T t) and import again"};
    case Direction::rotation_inverted:
      return {"quaternion_conjugated", "the rotations are world-to-camera, the positions are camera centres",
              "conjugate the quaternions (negate qx, qy, qz) and import again"};
    default:
      return {"position_is_translation",
              "the positions are the translations t of X_camera = R X + t, not the camera centres",
              "replace the positions by C = -R^T t and import again"};
  }
}

Words words(CameraAxes axes) {
  if (axes == CameraAxes::right_up_back)
    return {"camera_axes_opengl",
            "the camera axes are x right, y up, z back (OpenGL, Bundler), not x right, y down, "
            "z forward",
            "turn the camera axes by 180 degrees about x (negate the second and third column of the rotation) and "
            "import again"};
  return {"camera_axes_body", "the rotations are those of a forward-right-down body, not of the camera",
          "apply the mounting of the camera on the body and import again"};
}

Words words(WorldAxes) {
  return {"world_axes_ned", "the world axes are north-east-down, not east-north-up",
          "swap the first two coordinates, negate the third, and import again"};
}

Words words(int turned_deg) {
  if (turned_deg == 180)
    return {"frame_turned_180", "the raster was turned by 180 degrees against the pose", "import again with --rotate"};
  if (turned_deg == 90)
    return {"frame_turned_90", "the raster was turned by 90 degrees clockwise against the pose",
            "store the image as it was exposed, or turn the pose about the optical axis"};
  return {"frame_turned_270", "the raster was turned by 90 degrees counter-clockwise against the pose",
          "store the image as it was exposed, or turn the pose about the optical axis"};
}

std::vector<Words> words(const PoseHypothesis& h) {
  std::vector<Words> parts;
  if (h.order != Order::wxyz) parts.push_back(words(h.order));
  if (h.direction != Direction::as_given) parts.push_back(words(h.direction));
  if (h.camera_axes != CameraAxes::right_down_forward) parts.push_back(words(h.camera_axes));
  if (h.world_axes != WorldAxes::east_north_up) parts.push_back(words(h.world_axes));
  if (h.turned_deg != 0) parts.push_back(words(h.turned_deg));
  return parts;
}

std::string join(const PoseHypothesis& h, std::string_view Words::*member, std::string_view separator) {
  std::string text;
  for (const auto& part : words(h)) {
    if (!text.empty()) text += separator;
    text += part.*member;
  }
  return text;
}

Mat3 reordered(const Mat3& rotation, Order order) {
  const auto q = geometry::quaternion(rotation);
  if (order == Order::was_xyzw) return geometry::rotation_matrix({q.qz, q.qw, q.qx, q.qy});
  if (order == Order::was_shifted_back) return geometry::rotation_matrix({q.qx, q.qy, q.qz, q.qw});
  return rotation;
}

// Clockwise by `deg` as seen in the raster: axes of the raster expressed in those of the exposure.
Mat3 roll(int deg) {
  Mat3 m = Mat3::Identity();
  if (deg == 180) m.diagonal() = Vec3(-1, -1, 1);
  // Turned by 90 clockwise, the exposure's right points down in the raster and its down points left.
  if (deg == 90) m << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  if (deg == 270) m << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  return m;
}

std::vector<PoseHypothesis> enumerate() {
  std::vector<PoseHypothesis> all;
  for (const auto order : {Order::wxyz, Order::was_xyzw, Order::was_shifted_back})
    for (const auto direction :
         {Direction::as_given, Direction::inverted, Direction::rotation_inverted, Direction::position_is_translation})
      for (const auto camera :
           {CameraAxes::right_down_forward, CameraAxes::right_up_back, CameraAxes::forward_right_down})
        for (const auto world : {WorldAxes::east_north_up, WorldAxes::north_east_down})
          all.push_back({order, direction, camera, world, 0});
  for (const int turned : {180, 90, 270}) {
    PoseHypothesis h;
    h.turned_deg = turned;
    all.push_back(h);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const PoseHypothesis& a, const PoseHypothesis& b) { return a.parts() < b.parts(); });
  return all;
}

}  // namespace

int PoseHypothesis::parts() const {
  return static_cast<int>(words(*this).size());
}
std::string PoseHypothesis::code() const {
  const auto text = join(*this, &Words::code, "+");
  return text.empty() ? "as_declared" : text;
}
std::string PoseHypothesis::meaning() const {
  return join(*this, &Words::meaning, "; and ");
}
std::string PoseHypothesis::remedy() const {
  return join(*this, &Words::remedy, "; then ");
}

RigidTransform PoseHypothesis::apply(const RigidTransform& given) const {
  RigidTransform pose = given;
  pose.rotation = reordered(pose.rotation, order);
  if (direction == Direction::inverted) pose = pose.inverse();
  if (direction == Direction::rotation_inverted) pose.rotation.transposeInPlace();
  if (direction == Direction::position_is_translation) pose.translation = -(pose.rotation * pose.translation);
  if (camera_axes == CameraAxes::right_up_back) pose.rotation = pose.rotation * Vec3(1, -1, -1).asDiagonal();
  if (camera_axes == CameraAxes::forward_right_down) {
    Mat3 body_camera;  // camera x = body y, camera y = body z, camera z = body x
    body_camera << 0, 0, 1, 1, 0, 0, 0, 1, 0;
    pose.rotation = pose.rotation * body_camera;
  }
  if (world_axes == WorldAxes::north_east_down) {
    Mat3 enu_ned;
    enu_ned << 0, 1, 0, 1, 0, 0, 0, 0, -1;
    pose = {enu_ned * pose.rotation, enu_ned * pose.translation};
  }
  pose.rotation = pose.rotation * roll(turned_deg);
  return pose;
}

const std::vector<PoseHypothesis>& pose_hypotheses() {
  static const std::vector<PoseHypothesis> all = enumerate();
  return all;
}

}  // namespace cairn::adjustment
