// True boxes of objects in images.
#pragma once

#include <optional>
#include <vector>

#include "geometry/rigid_transform.hpp"
#include "simulation/placement.hpp"
#include "survey/camera.hpp"
#include "visibility/scene.hpp"

namespace cairn::simulation {

// What of one object an image shows, hidden parts included.
struct Outline {
  geometry::PixelBox box;     // clipped to the image
  bool whole = false;         // nothing was clipped
  double inside_share = 1.0;  // area of the clipped box in that of the whole one; 0..1
};

// One object, prepared for many views.
class ObjectOutline {
 public:
  // Keeps the vertices that are extreme in at least one of 642 directions: the outline of the hull is that of the
  // mesh, to 0.3 % of its size for meshes of more vertices than that.
  explicit ObjectOutline(const geometry::TriangleMesh& exposed);

  // Distortion respected at vertices. Where parts lie outside the image or behind the camera the triangles are clipped.
  // Empty where no part of the object is in the image.
  [[nodiscard]] std::optional<Outline> seen(const survey::Camera& camera,
                                            const geometry::RigidTransform& T_world_camera) const;

  struct Sample {
    geometry::Vec3 point, normal;  // world; outward
  };
  // Points spread evenly over the exposed surface, drawn from a generator of its own.
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }
  [[nodiscard]] const geometry::Vec3& centre() const { return centre_; }
  [[nodiscard]] double radius() const { return radius_; }

 private:
  [[nodiscard]] std::optional<Outline> clipped(const survey::Camera& camera,
                                               const geometry::RigidTransform& T_world_camera) const;

  geometry::TriangleMesh mesh_;
  std::vector<geometry::Vec3> extreme_;
  std::vector<Sample> samples_;
  geometry::Vec3 centre_ = geometry::Vec3::Zero();
  double radius_ = 0.0;
};

// Everything that can hide an object.
class Obstruction {
 public:
  Obstruction(const geometry::TriangleMesh& terrain, const std::vector<PlacedObject>& objects);

  // Share of the outline's pixels inside the image in which the object itself is the first surface met: its samples
  // that face the camera, weighted by their solid angle. About 50 rays a view: standard error at most 0.07; where a
  // third of them meet nothing in the way the rest is not cast. 1 where no sample faces the camera.
  [[nodiscard]] double visible_share(std::size_t object, const ObjectOutline& outline, const survey::Camera& camera,
                                     const geometry::RigidTransform& T_world_camera) const;
  // Whether the straight line from `from` to `to` is free.
  [[nodiscard]] bool free(const geometry::Vec3& from, const geometry::Vec3& to) const;

 private:
  struct Joined {
    geometry::TriangleMesh mesh;
    std::vector<std::uint32_t> body_begin, body_end;  // triangles of each object's body
  };
  static Joined join(const geometry::TriangleMesh& terrain, const std::vector<PlacedObject>& objects);
  explicit Obstruction(Joined joined);

  std::vector<std::uint32_t> body_begin_, body_end_;
  visibility::Scene scene_;
};

}  // namespace cairn::simulation
