// Bullet 3, double precision, behind topple(). The foot's contacts are made by hand, one manifold a corner: a point on
// its plane has an exact distance and needs no margin, where Bullet's own hull against plane would round the corners
// and keep four points at most.
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "base/angle.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "dynamics/topple.hpp"

namespace cairn::dynamics {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

constexpr double kGravity = 9.80665;      // m/s^2
constexpr double kLifted_m = 1e-4;        // a corner farther from its pad than this has left it
constexpr double kOnPads_m = 1e-3;        // all corners nearer than this: the rock stands on its foot
constexpr double kSlipped_m = 1e-3;       // less is the solver's own creep
constexpr double kSlidShare = 0.1;        // of the foot's size
constexpr double kReach_m = 5e-3;         // corners this near take part in the solve
constexpr double kStillSpeed_m_s = 5e-4;  // slower than this (of any corner) for kStill_s: at rest
constexpr double kStill_s = 0.3;
constexpr double kResidual = 1e-14;  // m^2/s^2: the solver stops once an iteration changes velocities by less

btVector3 bt(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
Vec3 vec(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
Mat3 matrix(const btMatrix3x3& m) {
  Mat3 out;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) out(r, c) = m[r][c];
  return out;
}
btMatrix3x3 bt_matrix(const Mat3& m) {
  return {m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)};
}

Vec3 rotation_vector(const Mat3& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

// Inside the ring (counter-clockwise, convex).
bool inside(const std::vector<Vec3>& ring, const Vec3& p) {
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 a = ring[i].head<2>(), b = ring[(i + 1) % ring.size()].head<2>();
    if ((b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x()) < 0.0) return false;
  }
  return true;
}

void require_body(const RigidRock& rock) {
  if (!(rock.mass_kg > 0.0) || rock.foot_m.size() < 3 || !rock.inertia_kg_m2.allFinite())
    throw Error(ErrorCode::failed_precondition, "not a rigid body on a foot")
        .found(base::to_text(rock.mass_kg) + " kg, " + std::to_string(rock.foot_m.size()) + " corners");
}

// World coordinates are the mesh's minus its centre of mass, so that a survey's offset costs no digits.
class Run {
 public:
  Run(const RigidRock& rock, const BaseMotion& motion, const ToppleOptions& options, const BodyStart& start)
      : rock_(rock),
        motion_(motion),
        options_(options),
        dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    set_solver();
    add_body(start);
    add_ground();
    add_foot();
  }
  ~Run() {
    for (auto* manifold : foot_) dispatcher_.releaseManifold(manifold);
    world_.removeRigidBody(body_.get());
    world_.removeRigidBody(ground_.get());
  }
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  ToppleResult run() {
    ToppleResult result;
    const double limit = base::deg_to_rad(options_.topple_angle_deg);
    const double motion_end = motion_.duration(), end = motion_end + options_.settle_s;
    const auto steps = static_cast<std::int64_t>(std::ceil(end / options_.step_s - 1e-9));
    double next_sample = 0.0, still_since = 0.0;
    lifted_.assign(rock_.foot_m.size(), false);
    bool fell = false, still = false;
    observe(result, fell);
    for (std::int64_t i = 0;; ++i) {
      const double t = options_.step_s * static_cast<double>(i);
      result.time_s = t;
      if (options_.sample_s > 0.0 && t >= next_sample - 0.5 * options_.step_s) {
        result.path.push_back(sample(t));
        next_sample += options_.sample_s;
      }
      if (result.max_tilt_rad >= limit || fell) break;
      if (fastest_corner() > kStillSpeed_m_s || t < motion_end) still_since = t;
      still = t >= motion_end && t - still_since >= kStill_s;
      if (still || i >= steps) break;
      step(t);
      observe(result, fell);
    }
    const BodySample last = sample(result.time_s);
    result.rotation_vector_rad = last.rotation_vector_rad;
    result.outcome = outcome(result, fell, still, limit);
    return result;
  }

 private:
  void set_solver() {
    auto& info = world_.getSolverInfo();
    info.m_numIterations = static_cast<int>(options_.iterations);
    info.m_solverMode = SOLVER_USE_WARMSTARTING | SOLVER_USE_2_FRICTION_DIRECTIONS;
    // Penetration is put right without adding velocity; a spring needs the velocity.
    info.m_splitImpulse = options_.stiffness_n_m > 0.0 ? 0 : 1;
    info.m_splitImpulsePenetrationThreshold = 1e30;
    info.m_leastSquaresResidualThreshold = kResidual;
    info.m_restitutionVelocityThreshold = std::max(0.01, 4.0 * kGravity * options_.step_s);
    world_.setGravity({0, 0, 0});
  }

  void add_body(const BodyStart& start) {
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(rock_.inertia_kg_m2);
    Mat3 axes = eigen.eigenvectors();
    if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
    axes_ = axes;
    const btVector3 inertia = bt(eigen.eigenvalues());
    if (options_.surround == "none" || rock_.pieces_m.empty()) {
      shape_ = std::make_unique<btSphereShape>(options_.margin_m);
    } else {
      auto compound = std::make_unique<btCompoundShape>();
      for (const auto& piece : rock_.pieces_m) {
        auto hull = std::make_unique<btConvexHullShape>();
        for (const auto& p : piece) hull->addPoint(bt(axes.transpose() * (p - rock_.centre_of_mass_m)), false);
        hull->recalcLocalAabb();
        hull->setMargin(options_.margin_m);
        compound->addChildShape(btTransform::getIdentity(), hull.get());
        pieces_.push_back(std::move(hull));
      }
      shape_ = std::move(compound);
    }
    const auto& T = start.T_world_start;
    // T acts in the mesh's frame; here the centre of mass is the origin.
    const Vec3 centre = T * rock_.centre_of_mass_m - rock_.centre_of_mass_m;
    const btTransform pose(bt_matrix(T.rotation * axes), bt(centre));
    state_ = std::make_unique<btDefaultMotionState>(pose);
    btRigidBody::btRigidBodyConstructionInfo info(rock_.mass_kg, state_.get(), shape_.get(), inertia);
    info.m_friction = options_.friction;
    info.m_restitution = options_.restitution;
    info.m_linearDamping = 0.0;
    info.m_angularDamping = 0.0;
    body_ = std::make_unique<btRigidBody>(info);
    body_->setActivationState(DISABLE_DEACTIVATION);
    body_->setLinearVelocity(bt(start.velocity_m_s));
    body_->setAngularVelocity(bt(start.angular_velocity_rad_s));
    const bool strikes = !pieces_.empty();
    world_.addRigidBody(body_.get(), 1, strikes ? 2 : 0);
    body_->setFlags(BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY | BT_DISABLE_WORLD_GRAVITY);
  }

  void add_ground() {
    Vec3 lowest = rock_.foot_m.front();
    for (const auto& q : rock_.foot_m)
      if (rock_.pad_normal.dot(q - lowest) < 0.0) lowest = q;
    const double offset = rock_.pad_normal.dot(lowest - rock_.centre_of_mass_m) - options_.margin_m;
    ground_shape_ = std::make_unique<btStaticPlaneShape>(bt(rock_.pad_normal), offset);
    ground_shape_->setMargin(0.0);
    btRigidBody::btRigidBodyConstructionInfo info(0.0, nullptr, ground_shape_.get());
    info.m_friction = 1.0;
    info.m_restitution = 1.0;
    ground_ = std::make_unique<btRigidBody>(info);
    world_.addRigidBody(ground_.get(), 2, pieces_.empty() ? 0 : 1);
  }

  void add_foot() {
    for (const auto& q : rock_.foot_m) {
      pads_.push_back(q - rock_.centre_of_mass_m);
      corners_.push_back(axes_.transpose() * (q - rock_.centre_of_mass_m));
      btPersistentManifold* manifold = dispatcher_.getNewManifold(body_.get(), ground_.get());
      manifold->setContactProcessingThreshold(BT_LARGE_FLOAT);
      foot_.push_back(manifold);
    }
    double size = 0.0;
    for (const auto& a : pads_)
      for (const auto& b : pads_) size = std::max(size, (a - b).norm());
    foot_size_ = size;
    for (const auto& p : pads_) foot_middle_ += p / static_cast<double>(pads_.size());
  }

  [[nodiscard]] Vec3 corner(std::size_t i) const { return vec(body_->getWorldTransform() * bt(corners_[i])); }
  [[nodiscard]] double gap(std::size_t i) const { return rock_.pad_normal.dot(corner(i) - pads_[i]); }
  [[nodiscard]] Vec3 corner_velocity(std::size_t i) const {
    return vec(body_->getVelocityInLocalPoint(bt(corner(i)) - body_->getCenterOfMassPosition()));
  }
  [[nodiscard]] double fastest_corner() const {
    double most = 0.0;
    for (std::size_t i = 0; i < corners_.size(); ++i) most = std::max(most, corner_velocity(i).norm());
    return most;
  }

  void set_contact(std::size_t i) {
    btPersistentManifold& manifold = *foot_[i];
    const Vec3 p = corner(i);
    double distance = gap(i);
    const double approach = rock_.pad_normal.dot(corner_velocity(i));
    bool active = distance < kReach_m;
    // A corner that will land within this step bounces from where it is: Bullet would first spend its speed on the gap.
    if (options_.restitution > 0.0 && distance > 0.0) {
      active = active && distance + (approach - kGravity * options_.step_s) * options_.step_s <= 0.0;
      distance = 0.0;
    }
    if (!active) {
      if (manifold.getNumContacts() > 0) manifold.clearManifold();
      return;
    }
    const bool known = manifold.getNumContacts() > 0;
    btManifoldPoint fresh;
    btManifoldPoint& point = known ? manifold.getContactPoint(0) : fresh;
    point.m_localPointA = bt(corners_[i]);
    point.m_positionWorldOnA = bt(p);
    point.m_positionWorldOnB = bt(p - distance * rock_.pad_normal);
    point.m_localPointB = point.m_positionWorldOnB;
    point.m_normalWorldOnB = bt(rock_.pad_normal);
    point.m_distance1 = distance;
    point.m_combinedFriction = options_.friction;
    point.m_combinedRestitution = options_.restitution;
    point.m_contactPointFlags = 0;
    if (options_.stiffness_n_m > 0.0) {
      point.m_contactPointFlags = BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
      point.m_combinedContactStiffness1 = options_.stiffness_n_m;
      point.m_combinedContactDamping1 = options_.damping_ns_m;
    }
    if (!known) manifold.addManifoldPoint(fresh);
  }

  void step(double t) {
    for (std::size_t i = 0; i < corners_.size(); ++i) set_contact(i);
    const Vec3 change = motion_.velocity(t + options_.step_s) - (t > 0.0 ? motion_.velocity(t) : Vec3(Vec3::Zero()));
    const Vec3 force = -rock_.mass_kg * (Vec3(0, 0, kGravity) + change / options_.step_s);
    body_->applyCentralForce(bt(force));
    world_.stepSimulation(options_.step_s, 0, options_.step_s);
  }

  void observe(ToppleResult& result, bool& fell) {
    const Vec3 turn = rotation_vector(matrix(body_->getWorldTransform().getBasis()) * axes_.transpose());
    const double tilt = turn.head<2>().norm();
    if (tilt > result.max_tilt_rad) {
      result.max_tilt_rad = tilt;
      const double toward = base::rad_to_deg(std::atan2(turn.y(), -turn.x()));
      result.tilt_toward_deg = toward < 0.0 ? toward + 360.0 : toward;
    }
    double highest = 0.0;
    Vec3 middle = Vec3::Zero();
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const double g = gap(i);
      highest = std::max(highest, g);
      if (lifted_[i] && g < 0.1 * kLifted_m) {
        lifted_[i] = false;
        ++result.impacts;
      } else if (g > kLifted_m) {
        lifted_[i] = true;
      }
      middle += corner(i) / static_cast<double>(corners_.size());
    }
    result.max_lift_m = std::max(result.max_lift_m, highest);
    if (highest < kOnPads_m) {
      result.slip_m = std::max(result.slip_m, (middle - foot_middle_).head<2>().norm());
      fell = !inside(pads_, vec(body_->getCenterOfMassPosition()));
    }
  }

  [[nodiscard]] BodySample sample(double t) const {
    const btTransform& pose = body_->getWorldTransform();
    const Mat3 rotation = matrix(pose.getBasis());
    const Vec3 v = vec(body_->getLinearVelocity()), w = vec(body_->getAngularVelocity());
    const Mat3 turn = rotation * axes_.transpose();
    const Mat3 inertia = turn * rock_.inertia_kg_m2 * turn.transpose();
    BodySample s;
    s.time_s = t;
    s.displacement_m = vec(pose.getOrigin());
    s.rotation_vector_rad = rotation_vector(turn);
    s.energy_j = 0.5 * rock_.mass_kg * v.squaredNorm() + 0.5 * w.dot(inertia * w) +
                 rock_.mass_kg * kGravity * s.displacement_m.z();
    return s;
  }

  [[nodiscard]] ToppleOutcome outcome(const ToppleResult& result, bool fell, bool still, double limit) const {
    if (result.max_tilt_rad >= limit) return ToppleOutcome::toppled;
    if (fell) return ToppleOutcome::fell_off;
    if (!still) return ToppleOutcome::undecided;
    if (result.slip_m >= kSlidShare * foot_size_) return ToppleOutcome::slid;
    return result.max_lift_m <= kLifted_m && result.slip_m < kSlipped_m ? ToppleOutcome::rested : ToppleOutcome::rocked;
  }

  const RigidRock& rock_;
  const BaseMotion& motion_;
  const ToppleOptions& options_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btConvexHullShape>> pieces_;
  std::unique_ptr<btCollisionShape> shape_, ground_shape_;
  std::unique_ptr<btDefaultMotionState> state_;
  std::unique_ptr<btRigidBody> body_, ground_;
  std::vector<btPersistentManifold*> foot_;  // one a corner; owned by the dispatcher
  std::vector<Vec3> corners_;                // in the body's principal axes, from the centre of mass
  std::vector<Vec3> pads_;                   // world
  std::vector<bool> lifted_;
  Mat3 axes_ = Mat3::Identity();  // principal axes in the mesh's frame
  Vec3 foot_middle_ = Vec3::Zero();
  double foot_size_ = 0.0;
};

}  // namespace

ToppleResult topple(const RigidRock& rock, const BaseMotion& motion, const ToppleOptions& options,
                    const BodyStart& start) {
  ToppleOptions checked = options;
  base::validate(base::bind_options(checked), "dynamics");
  require_body(rock);
  require_valid(motion);
  return Run(rock, motion, options, start).run();
}

}  // namespace cairn::dynamics
