// Rigid-body toppling in three dimensions under a moving base.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/options.hpp"
#include "dynamics/base_motion.hpp"
#include "dynamics/rigid_rock.hpp"
#include "geometry/rigid_transform.hpp"
#include "geometry/vec.hpp"

namespace cairn::dynamics {

// Everything the answer depends on. The defaults of friction and restitution are those of rock on rock as used by the
// virtual shake robot for rocks, upper end; the step and the iterations were chosen by step_convergence().
struct ToppleOptions {
  double friction = 0.65;         // Coulomb, at the foot and at the flanks
  double restitution = 0.0;       // Newton's, of the normal velocity at a corner of the foot that lands
  double margin_m = 0.001;        // flanks: shapes are rounded by this; the foot has no margin
  double stiffness_n_m = 0.0;     // of each corner of the foot; 0 = rigid
  double damping_ns_m = 0.0;      // of each corner of the foot, with a stiffness
  double step_s = 5e-4;           // fixed time step
  std::int64_t iterations = 100;  // of the sequential-impulse solver, each step
  // What the flanks can strike: "none" (a pedestal no wider than the foot) or "plane" (level ground at the foot, along
  // the pads).
  std::string surround = "none";
  // Toppled: the rotation vector without its part about the vertical is at least this [deg], at any time.
  double topple_angle_deg = 60.0;
  double settle_s = 10.0;  // simulated at most this long after the motion
  // Times at which the path is kept [s]; 0 = no path.
  double sample_s = 0.0;

  void visit(base::OptionVisitor& visitor);
};

// rested: the foot never left its pads by more than 1e-4 m and slipped less than 1 mm; rocked: it lifted and came back;
// slid: it stands, but slipped by a tenth of the foot's size or more; fell_off: it slipped until the plumb point left
// the pads' polygon; toppled: see topple_angle_deg; undecided: still moving at the end.
enum class ToppleOutcome { rested, rocked, slid, fell_off, toppled, undecided };
[[nodiscard]] std::string_view name_of(ToppleOutcome outcome);

struct BodySample {
  double time_s = 0.0;
  geometry::Vec3 displacement_m = geometry::Vec3::Zero();       // of the centre of mass, relative to the ground
  geometry::Vec3 rotation_vector_rad = geometry::Vec3::Zero();  // of the body, from the pose of the mesh
  double energy_j = 0.0;                                        // kinetic + potential, relative to the ground at rest
};

struct ToppleResult {
  ToppleOutcome outcome = ToppleOutcome::undecided;
  double time_s = 0.0;        // simulated
  double max_tilt_rad = 0.0;  // greatest rotation without its part about the vertical
  // Where the top went at that time, deg clockwise from +y; 0 where max_tilt is 0.
  double tilt_toward_deg = 0.0;
  geometry::Vec3 rotation_vector_rad = geometry::Vec3::Zero();  // at the end
  double slip_m = 0.0;       // greatest level movement of the foot's middle, when on its pads
  double max_lift_m = 0.0;   // greatest distance of the highest corner of the foot from its pad
  std::int64_t impacts = 0;  // corners that landed after having lifted by more than 1e-4 m
  std::vector<BodySample> path;

  [[nodiscard]] bool toppled() const { return outcome == ToppleOutcome::toppled || outcome == ToppleOutcome::fell_off; }
};

// Where the body starts; by default at rest in the pose of the mesh.
struct BodyStart {
  geometry::RigidTransform T_world_start;  // moves the mesh's frame
  geometry::Vec3 velocity_m_s = geometry::Vec3::Zero();
  geometry::Vec3 angular_velocity_rad_s = geometry::Vec3::Zero();
};

// Bullet (double precision) integrates the body in the frame of the ground, whose motion enters exactly as the change
// of its velocity over each step. Mass, centre and inertia are the rock's own; the foot's corners are point contacts on
// planes with no margin, so that a block tips at its edge; flanks are convex hulls. Semi-implicit Euler, first order in
// the step. Friction acts along the slip and across it (a pyramid turned with the slip). One thread, no random order:
// the same bytes on every run of one machine's Bullet.
// Limits: rigid, no crushing of corners, contact never changes shape, impacts lose what Newton's law with the given
// restitution says (0 gives Housner's loss for a block).
// Cost: 20 us a step while it rocks, 70 us while it rests on 40 corners.
[[nodiscard]] ToppleResult topple(const RigidRock& rock, const BaseMotion& motion, const ToppleOptions& options = {},
                                  const BodyStart& start = {});

// The same run with ever smaller steps.
struct StepStudyRow {
  double step_s = 0.0;
  ToppleOutcome outcome = ToppleOutcome::undecided;
  double max_tilt_rad = 0.0;
  double time_s = 0.0;
};
struct StepStudy {
  std::vector<StepStudyRow> rows;  // coarse to fine, each half the step before
  // The last two rows agree: the same answer to toppled(), and where neither toppled the greatest tilts within
  // 5 % or 0.1 deg.
  bool converged = false;
};
[[nodiscard]] StepStudy step_convergence(const RigidRock& rock, const BaseMotion& motion, const ToppleOptions& options,
                                         int halvings = 3, const BodyStart& start = {});

}  // namespace cairn::dynamics
