// Which photographs show a rock and its contact.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "base/angle.hpp"
#include "camera/projection.hpp"
#include "pipeline/rock_figures.hpp"
#include "visibility/scene.hpp"

namespace cairn::pipeline {
namespace {

using geometry::Vec2;
using geometry::Vec3;

constexpr double kLeastPixels = 24.0;
constexpr double kApart_deg = 40.0;
constexpr double kSkin = 0.02;  // of the rock's size: a contact vertex may lie this deep under the closed mesh

std::optional<geometry::PixelBox> box_of(const geometry::TriangleMesh& mesh, const survey::Camera& camera,
                                         const geometry::RigidTransform& pose) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  geometry::PixelBox box{kInfinity, kInfinity, -kInfinity, -kInfinity};
  for (const auto& v : mesh.vertices) {
    const auto pixel = camera::project_world(camera, pose, v);
    if (!pixel || !camera::inside_image(camera, *pixel)) return std::nullopt;
    box.xmin = std::min(box.xmin, pixel->x());
    box.xmax = std::max(box.xmax, pixel->x());
    box.ymin = std::min(box.ymin, pixel->y());
    box.ymax = std::max(box.ymax, pixel->y());
  }
  return box;
}

double score(const RockPhoto& photo) {
  return std::max(photo.box.width(), photo.box.height()) * (0.2 + photo.contact_in_sight);
}

double apart(double a, double b) {
  const double d = std::fmod(std::abs(a - b), 360.0);
  return std::min(d, 360.0 - d);
}

}  // namespace

std::vector<RockPhoto> rock_photos(const geometry::TriangleMesh& mesh, const survey::Contact& contact,
                                   const survey::Survey& survey, std::size_t count) {
  std::vector<RockPhoto> all;
  if (mesh.triangles.empty() || count == 0) return all;
  const double size = mesh.bounds().size().norm();
  const visibility::Scene scene(mesh);
  std::vector<Vec3> targets;
  for (const auto& v : contact) targets.push_back(v.position);
  for (const auto& frame : survey.frames) {
    const auto* camera = survey.camera(frame.camera);
    if (camera == nullptr || frame.image.empty()) continue;
    const Vec3 eye = frame.T_world_camera.translation;
    const Vec3 look = mesh.bounds().centre() - eye;
    // Most frames of a survey look elsewhere: one point tells before all of them are projected.
    const auto middle = camera::project_world(*camera, frame.T_world_camera, mesh.bounds().centre());
    if (!middle || !camera::inside_image(*camera, *middle)) continue;
    const auto box = box_of(mesh, *camera, frame.T_world_camera);
    if (!box || std::max(box->width(), box->height()) < kLeastPixels) continue;
    RockPhoto photo{frame.id, *box, std::vector<std::uint8_t>(targets.size()), 0.0, 0.0};
    photo.azimuth_deg = std::fmod(base::rad_to_deg(std::atan2(look.x(), look.y())) + 360.0, 360.0);
    scene.blocked_from(eye, targets, photo.hidden, std::min(0.5, kSkin * size / std::max(look.norm(), 1e-9)));
    const auto seen = std::count(photo.hidden.begin(), photo.hidden.end(), std::uint8_t{0});
    photo.contact_in_sight = targets.empty() ? 0.0 : static_cast<double>(seen) / static_cast<double>(targets.size());
    all.push_back(std::move(photo));
  }
  std::stable_sort(all.begin(), all.end(), [](const RockPhoto& a, const RockPhoto& b) { return score(a) > score(b); });
  std::vector<RockPhoto> chosen, rest;
  for (auto& photo : all) {
    const bool differs = std::all_of(chosen.begin(), chosen.end(), [&](const RockPhoto& c) {
      return apart(c.azimuth_deg, photo.azimuth_deg) >= kApart_deg;
    });
    (differs && chosen.size() < count ? chosen : rest).push_back(std::move(photo));
  }
  for (auto& photo : rest)
    if (chosen.size() < count) chosen.push_back(std::move(photo));
  return chosen;
}

}  // namespace cairn::pipeline
