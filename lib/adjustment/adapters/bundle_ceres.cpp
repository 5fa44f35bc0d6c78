// The Levenberg-Marquardt solve by Ceres: one thread, analytic Jacobians, points eliminated first.
#include <ceres/ceres.h>
#include <glog/logging.h>

#include <algorithm>
#include <deque>
#include <memory>
#include <span>

#include "adjustment/bundle_system.hpp"
#include "base/error.hpp"

namespace cairn::adjustment {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;

using Wide = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::RowMajor>;
constexpr int kPoseSize = 6;
constexpr std::size_t kPose = kPoseSize;
constexpr std::size_t kDenseFrames = 100;  // up to here the dense reduced system is faster than a sparse one

// What every observation of a pose shares, worked out once an evaluation.
struct PoseState {
  geometry::RigidTransform start;  // increments are taken about it
  Mat3 R_camera_world, right_jacobian;
  Vec3 centre;
};

// Parameter blocks and what follows from them.
struct Blocks : ceres::EvaluationCallback {
  camera::IntrinsicsSet set = camera::IntrinsicsSet::none;
  // One buffer: the solver orders blocks by their addresses, and the result must not depend on the heap's.
  std::vector<double> values;
  std::vector<std::span<double>> pose_values;  // increment; with its camera's intrinsics where nobody shares them
  std::vector<std::span<double>> camera_values;
  std::vector<bool> merged;  // per camera: its values stand in its one pose's block
  std::vector<std::int32_t> camera_of;
  std::vector<PoseState> poses;
  std::vector<survey::Camera> cameras;

  void PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_evaluation_point) override {
    if (new_evaluation_point) update();
  }

  void update() {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      auto& pose = poses[i];
      const Eigen::Map<const Vec3> w(pose_values[i].data()), v(pose_values[i].data() + 3);
      pose.R_camera_world = (pose.start.rotation * exp_rotation(w)).transpose();
      pose.right_jacobian = right_jacobian(w);
      pose.centre = pose.start.translation + v;
      const auto c = static_cast<std::size_t>(camera_of[i]);
      if (merged[c]) set_camera(c, pose_values[i].subspan(kPose));
    }
    for (std::size_t c = 0; c < cameras.size(); ++c)
      if (!merged[c]) set_camera(c, camera_values[c]);
  }

 private:
  void set_camera(std::size_t c, std::span<const double> parameters) {
    if (!parameters.empty()) cameras[c] = camera::with_intrinsics(cameras[c], set, parameters);
  }
};

// Where a point cannot be projected the error is this many sigmas, without a slope: such a step is never worth it.
constexpr double kBehind = 1e4;

class Reprojection final : public ceres::CostFunction {
 public:
  Reprojection(const BundleObservation& observation, const PoseState& pose, const survey::Camera& camera,
               camera::IntrinsicsSet set, int intrinsics, bool merged)
      : observation_(&observation),
        pose_(&pose),
        camera_(&camera),
        set_(set),
        intrinsics_(intrinsics),
        merged_(merged) {
    set_num_residuals(2);
    auto* sizes = mutable_parameter_block_sizes();
    sizes->reserve(3);
    sizes->push_back(3);
    sizes->push_back(kPoseSize + (merged ? intrinsics : 0));
    if (!merged && intrinsics > 0) sizes->push_back(intrinsics);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Vec3 p_camera = pose_->R_camera_world * (Eigen::Map<const Vec3>(parameters[0]) - pose_->centre);
    Vec2 pixel;
    camera::PointJacobian by_camera;
    camera::IntrinsicsJacobian by_intrinsics;
    const bool wants_intrinsics = jacobians != nullptr && intrinsics_ > 0 && jacobians[merged_ ? 1 : 2] != nullptr;
    if (!camera::project_with_jacobian(*camera_, p_camera, set_, pixel, by_camera,
                                       wants_intrinsics ? &by_intrinsics : nullptr)) {
      behind(residuals, jacobians);
      return true;
    }
    const double weight = observation_->weight;
    residuals[0] = weight * (pixel.x() - observation_->pixel.x());
    residuals[1] = weight * (pixel.y() - observation_->pixel.y());
    if (jacobians == nullptr) return true;
    by_camera *= weight;
    const camera::PointJacobian by_point = by_camera * pose_->R_camera_world;
    if (jacobians[0] != nullptr) {
      Eigen::Map<camera::PointJacobian> block(jacobians[0]);
      block = by_point;
    }
    if (jacobians[1] != nullptr) {
      const int width = kPoseSize + (merged_ ? intrinsics_ : 0);
      Eigen::Map<Wide> by_pose(jacobians[1], 2, width);
      // Row times [p]x, then times the right Jacobian.
      camera::PointJacobian by_turn;
      for (int r = 0; r < 2; ++r) by_turn.row(r) << cross(by_camera.row(r), p_camera);
      by_pose.leftCols<3>().noalias() = by_turn * pose_->right_jacobian;
      by_pose.middleCols<3>(3) = -by_point;
      if (merged_ && intrinsics_ > 0) by_pose.rightCols(intrinsics_) = weight * by_intrinsics.leftCols(intrinsics_);
    }
    if (wants_intrinsics && !merged_) {
      Eigen::Map<Wide> block(jacobians[2], 2, intrinsics_);
      block = weight * by_intrinsics.leftCols(intrinsics_);
    }
    return true;
  }

 private:
  // a^T [p]x
  static Eigen::RowVector3d cross(const Eigen::RowVector3d& a, const Vec3& p) {
    return {a.y() * p.z() - a.z() * p.y(), a.z() * p.x() - a.x() * p.z(), a.x() * p.y() - a.y() * p.x()};
  }

  void behind(double* residuals, double** jacobians) const {
    residuals[0] = residuals[1] = kBehind;
    if (jacobians == nullptr) return;
    for (std::size_t b = 0; b < parameter_block_sizes().size(); ++b)
      if (jacobians[b] != nullptr) std::fill_n(jacobians[b], 2 * parameter_block_sizes()[b], 0.0);
  }

  const BundleObservation* observation_;
  const PoseState* pose_;
  const survey::Camera* camera_;
  camera::IntrinsicsSet set_;
  int intrinsics_;
  bool merged_;
};

class PosePrior final : public ceres::CostFunction {
 public:
  PosePrior(const BundlePrior& prior, const PoseState& pose, int width) : prior_(&prior), pose_(&pose), width_(width) {
    set_num_residuals(kPoseSize);
    mutable_parameter_block_sizes()->push_back(width);
  }

  bool Evaluate(double const* const* /*parameters*/, double* residuals, double** jacobians) const override {
    const Vec3 turn = log_rotation(prior_->pose.rotation.transpose() * pose_->R_camera_world.transpose());
    const Vec3 shift_weight(prior_->weight_xy, prior_->weight_xy, prior_->weight_z);
    Eigen::Map<Vec3> by_turn(residuals), by_shift(residuals + 3);
    by_turn = prior_->weight_rot * turn;
    by_shift = shift_weight.cwiseProduct(pose_->centre - prior_->pose.translation);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, kPoseSize, Eigen::Dynamic, Eigen::RowMajor>> jacobian(jacobians[0], kPoseSize,
                                                                                           width_);
    jacobian.setZero();
    if (prior_->weight_rot > 0.0)
      jacobian.topLeftCorner<3, 3>() = prior_->weight_rot * inverse_right_jacobian(turn) * pose_->right_jacobian;
    for (int i = 0; i < 3; ++i) jacobian(3 + i, 3 + i) = shift_weight[i];
    return true;
  }

 private:
  const BundlePrior* prior_;
  const PoseState* pose_;
  int width_;
};

class PointPrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit PointPrior(const BundlePointPrior& prior) : prior_(&prior) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Vec3> error(residuals);
    error = prior_->weight.cwiseProduct(Eigen::Map<const Vec3>(parameters[0]) - prior_->position);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Mat3> block(jacobians[0]);  // diagonal: the same in either order
    block = prior_->weight.asDiagonal();
    return true;
  }

 private:
  const BundlePointPrior* prior_;
};

std::unique_ptr<ceres::LossFunction> loss_of(BundleLoss loss, double scale) {
  switch (loss) {
    case BundleLoss::none: return nullptr;
    case BundleLoss::huber: return std::make_unique<ceres::HuberLoss>(scale);
    case BundleLoss::cauchy: return std::make_unique<ceres::CauchyLoss>(scale);
  }
  return nullptr;
}

void fill_blocks(const BundleSystem& system, Blocks& blocks) {
  blocks.set = system.intrinsics;
  blocks.cameras = system.cameras;
  blocks.camera_of = system.camera_of;
  std::vector<int> users(system.cameras.size(), 0);
  for (const auto c : system.camera_of) ++users[static_cast<std::size_t>(c)];
  std::vector<std::vector<double>> intrinsics;
  std::size_t total = kPose * system.poses.size();
  for (std::size_t c = 0; c < system.cameras.size(); ++c) {
    blocks.merged.push_back(users[c] == 1);
    intrinsics.push_back(camera::intrinsics_of(system.cameras[c], system.intrinsics));
    total += intrinsics.back().size();
  }
  blocks.values.assign(total, 0.0);
  std::span<double> free = blocks.values;
  const auto take = [&](std::size_t count) {
    const auto block = free.first(count);
    free = free.subspan(count);
    return block;
  };
  for (std::size_t i = 0; i < system.poses.size(); ++i) {
    const auto c = static_cast<std::size_t>(system.camera_of[i]);
    blocks.pose_values.push_back(take(kPose + (blocks.merged[c] ? intrinsics[c].size() : 0)));
    if (blocks.merged[c])
      std::copy(intrinsics[c].begin(), intrinsics[c].end(), blocks.pose_values.back().subspan(kPose).begin());
    blocks.poses.push_back({system.poses[i], Mat3::Identity(), Mat3::Identity(), Vec3::Zero()});
  }
  for (std::size_t c = 0; c < system.cameras.size(); ++c) {
    blocks.camera_values.push_back(take(blocks.merged[c] ? 0 : intrinsics[c].size()));
    if (!blocks.merged[c]) std::copy(intrinsics[c].begin(), intrinsics[c].end(), blocks.camera_values[c].begin());
  }
  blocks.update();
}

// Ends the solve at the next iteration once a stop was requested.
class StopCallback final : public ceres::IterationCallback {
 public:
  explicit StopCallback(const base::RunContext& ctx) : ctx_(&ctx) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    ctx_->progress("iterations", static_cast<std::uint64_t>(summary.iteration), 0);
    try {
      ctx_->check_stop();
    } catch (const base::Error&) {
      return ceres::SOLVER_ABORT;
    }
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const base::RunContext* ctx_;
};

ceres::Solver::Options solver_options(const BundleSystem& system, const SolveLimits& limits) {
  ceres::Solver::Options options;
  options.max_num_iterations = static_cast<int>(limits.max_iterations);
  options.function_tolerance = limits.function_tolerance;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.num_threads = 1;
  options.jacobi_scaling = false;  // the damping is scaled already: a pass over the Jacobian less
  options.logging_type = ceres::SILENT;
  // Eigen's factorisations: the system's BLAS may run threads of its own.
  options.dense_linear_algebra_library_type = ceres::EIGEN;
  options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
  options.linear_solver_type = system.poses.size() <= kDenseFrames ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  return options;
}

}  // namespace

BundleRound solve_bundle(BundleSystem& system, const SolveLimits& limits, base::RunContext& ctx) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // a library does not print
  Blocks blocks;
  fill_blocks(system, blocks);
  const auto tie_loss = loss_of(system.loss, system.loss_scale);
  const auto prior_loss =
      loss_of(system.prior_loss_scale > 0.0 ? BundleLoss::huber : BundleLoss::none, system.prior_loss_scale);
  std::deque<Reprojection> reprojections;
  std::deque<PosePrior> pose_priors;
  std::deque<PointPrior> point_priors;

  ceres::Problem::Options problem_options;
  problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.disable_all_safety_checks = true;
  problem_options.evaluation_callback = &blocks;
  ceres::Problem problem(problem_options);
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  std::vector<int> intrinsics(system.cameras.size());
  for (std::size_t c = 0; c < system.cameras.size(); ++c)
    intrinsics[c] = camera::intrinsics_count(system.cameras[c].model, system.intrinsics);
  for (auto& point : system.points) {
    problem.AddParameterBlock(point.data(), 3);
    ordering->AddElementToGroup(point.data(), 0);
  }
  for (const auto values : blocks.pose_values) {
    problem.AddParameterBlock(values.data(), static_cast<int>(values.size()));
    ordering->AddElementToGroup(values.data(), 1);
  }
  for (const auto values : blocks.camera_values) {
    if (values.empty()) continue;
    problem.AddParameterBlock(values.data(), static_cast<int>(values.size()));
    ordering->AddElementToGroup(values.data(), 1);
  }
  for (const auto& o : system.observations) {
    const auto f = static_cast<std::size_t>(o.frame);
    const auto c = static_cast<std::size_t>(system.camera_of[f]);
    double* point = system.points[static_cast<std::size_t>(o.point)].data();
    auto& cost = reprojections.emplace_back(o, blocks.poses[f], blocks.cameras[c], system.intrinsics, intrinsics[c],
                                            blocks.merged[c]);
    if (intrinsics[c] > 0 && !blocks.merged[c])
      problem.AddResidualBlock(&cost, tie_loss.get(), point, blocks.pose_values[f].data(),
                               blocks.camera_values[c].data());
    else problem.AddResidualBlock(&cost, tie_loss.get(), point, blocks.pose_values[f].data());
  }
  for (std::size_t f = 0; f < system.priors.size(); ++f) {
    if (!system.priors[f].any()) continue;
    const auto values = blocks.pose_values[f];
    auto& cost = pose_priors.emplace_back(system.priors[f], blocks.poses[f], static_cast<int>(values.size()));
    problem.AddResidualBlock(&cost, prior_loss.get(), values.data());
  }
  for (const auto& prior : system.point_priors)
    problem.AddResidualBlock(&point_priors.emplace_back(prior), nullptr,
                             system.points[static_cast<std::size_t>(prior.point)].data());

  auto options = solver_options(system, limits);
  options.linear_solver_ordering = ordering;
  StopCallback stop(ctx);
  options.callbacks.push_back(&stop);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  ctx.check_stop();
  blocks.update();
  for (std::size_t f = 0; f < system.poses.size(); ++f)
    system.poses[f] = {blocks.poses[f].R_camera_world.transpose(), blocks.poses[f].centre};
  system.cameras = blocks.cameras;

  BundleRound round;
  round.iterations = static_cast<std::int64_t>(summary.iterations.size()) - 1;
  round.cost_before = summary.initial_cost;
  round.cost_after = summary.final_cost;
  round.observations = system.observations.size();
  round.converged = summary.termination_type == ceres::CONVERGENCE;
  round.termination = summary.message;
  return round;
}

}  // namespace cairn::adjustment
