// One rigid body for other simulators: URDF and SDF, written with consistent figures, read and proved.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/reject.hpp"
#include "geometry/mass_properties.hpp"
#include "geometry/rigid_transform.hpp"
#include "geometry/triangle_mesh.hpp"

namespace cairn::io {

// A link as URDF and SDF both know it. SI.
struct RobotLink {
  std::string name;
  double mass_kg = 0.0;
  geometry::RigidTransform T_link_inertial;  // its origin is the centre of mass
  // About the centre of mass, along the axes of the inertial frame; off-diagonals are -Int xy dm in both formats.
  geometry::Mat3 inertia_kg_m2 = geometry::Mat3::Zero();
  std::vector<std::string> meshes;  // as written: of the visual and collision elements, each once
};

struct RobotDescription {
  std::string format;  // "urdf" or "sdf"
  std::string name;
  std::vector<RobotLink> links;
};

// By the root element: <robot> is URDF, <sdf> SDF (the first model). Throws invalid_input with file and byte: not XML,
// another root, a link without <inertial>, a number that is none. Above 16 MB refused.
[[nodiscard]] RobotDescription read_robot_description(const std::filesystem::path& path);

// Whether a link can be the body of that mesh (closed, outward, the same scale; its axes may differ from the link's by
// a rotation, so principal moments are compared). Reason codes:
//   inertia_not_a_body     not symmetric positive, or one principal moment above the sum of the others
//   inertia_not_the_box    tr(I)/m, twice the mean square distance from the centre, is not that of a solid of the
//   mesh's
//                          size: outside 0.2..1.5 times the solid box's (a^2 + b^2 + c^2)/6
//   inertia_not_the_mesh   a principal moment differs by more than 1 % from the mesh's at the link's mass
//   density_not_a_rock     mass / volume outside 1500..3500 kg/m^3
[[nodiscard]] std::vector<base::Reject> link_findings(const RobotLink& link, const geometry::TriangleMesh& mesh);

struct RobotModelOptions {
  std::string name = "rock";
  double density_kg_m3 = 2600.0;
  double friction = 0.65;  // SDF: ode mu, mu2; PyBullet reads its own tag in URDF
  double restitution = 0.0;
};

// Writes into an existing folder: mesh.obj, model.urdf, model.sdf, model.config (Gazebo). The mesh is moved so that its
// centre of mass is the origin: link, inertial and mesh frames are one, and simulators that hold single precision lose
// nothing to a survey's offset. The model's pose (SDF) and the OBJ's first lines say where that origin lies [m, mesh's
// frame]. The mesh must be closed and outward. Throws resource_exhausted where a write fails.
void write_robot_model(const std::filesystem::path& folder, const geometry::TriangleMesh& mesh,
                       const geometry::MassProperties& mass, const RobotModelOptions& options);

}  // namespace cairn::io
