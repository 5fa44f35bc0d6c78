#include "adjustment/bundle_covariance.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace cairn::adjustment {
namespace {

using geometry::Mat3;
using geometry::Vec2;
using geometry::Vec3;
using Matrix = Eigen::MatrixXd;

constexpr double kUnheldMetres = 1e3, kUnheldTurn = std::numbers::pi;

// Derivative of the loss at squared error s: the weight of a square in its place.
double loss_weight(BundleLoss loss, double scale, double s) {
  switch (loss) {
    case BundleLoss::none: return 1.0;
    case BundleLoss::huber: return s <= scale * scale ? 1.0 : scale / std::sqrt(s);
    case BundleLoss::cauchy: return 1.0 / (1.0 + s / (scale * scale));
  }
  return 1.0;
}

struct Column {
  Eigen::Index start;
  Eigen::Matrix<double, 2, Eigen::Dynamic> jacobian;
  Eigen::Matrix<double, Eigen::Dynamic, 3> coupling;
};

class Normal {
 public:
  Normal(const BundleSystem& system, bool full) : system_(system), full_(full) {
    const auto poses = static_cast<Eigen::Index>(system.poses.size());
    Eigen::Index next = 6 * poses;
    for (const auto& camera : system.cameras) {
      intrinsics_.push_back(next);
      next += camera::intrinsics_count(camera.model, system.intrinsics);
    }
    size_ = next;
    if (full_) matrix_ = Matrix::Zero(next, next);
    else blocks_.assign(system.poses.size(), Mat6::Zero());
    for (std::size_t begin = 0; begin < system.observations.size();) {
      std::size_t end = begin;
      while (end < system.observations.size() && system.observations[end].point == system.observations[begin].point)
        ++end;
      add_point(begin, end);
      begin = end;
    }
    for (std::size_t f = 0; f < system.poses.size(); ++f) add_prior(f);
  }

  [[nodiscard]] Eigen::Index size() const { return size_; }
  [[nodiscard]] Matrix& matrix() { return matrix_; }
  [[nodiscard]] const std::vector<Mat6>& blocks() const { return blocks_; }

 private:
  void add(const Column& a, const Column& b, const Eigen::MatrixXd& value) {
    if (full_) {
      matrix_.block(a.start, b.start, value.rows(), value.cols()) += value;
    } else if (&a == &b && a.start < 6 * static_cast<Eigen::Index>(blocks_.size())) {
      blocks_[static_cast<std::size_t>(a.start / 6)] += value;
    }
  }

  void add_point(std::size_t begin, std::size_t end) {
    const auto p = static_cast<std::size_t>(system_.observations[begin].point);
    Mat3 point = Mat3::Zero();
    for (const auto& prior : system_.point_priors)
      if (static_cast<std::size_t>(prior.point) == p) point += Mat3(prior.weight.cwiseAbs2().asDiagonal());
    std::vector<Column> columns;
    for (std::size_t i = begin; i < end; ++i) {
      const auto& o = system_.observations[i];
      const auto f = static_cast<std::size_t>(o.frame), c = static_cast<std::size_t>(system_.camera_of[f]);
      const auto& pose = system_.poses[f];
      const Vec3 p_camera = pose.rotation.transpose() * (system_.points[p] - pose.translation);
      Vec2 pixel;
      camera::PointJacobian by_camera;
      camera::IntrinsicsJacobian by_intrinsics;
      if (!camera::project_with_jacobian(system_.cameras[c], p_camera, system_.intrinsics, pixel, by_camera,
                                         &by_intrinsics))
        continue;
      const double squared = (o.weight * (pixel - o.pixel)).squaredNorm();
      const double weight = o.weight * std::sqrt(loss_weight(system_.loss, system_.loss_scale, squared));
      const camera::PointJacobian by_point = weight * by_camera * pose.rotation.transpose();
      Column column{6 * o.frame, Matrix(2, 6), {}};
      Mat3 cross;
      cross << 0.0, -p_camera.z(), p_camera.y(), p_camera.z(), 0.0, -p_camera.x(), -p_camera.y(), p_camera.x(), 0.0;
      column.jacobian.leftCols<3>() = weight * by_camera * cross;
      column.jacobian.rightCols<3>() = -by_point;
      column.coupling = column.jacobian.transpose() * by_point;
      point += by_point.transpose() * by_point;
      columns.push_back(std::move(column));
      const int count = camera::intrinsics_count(system_.cameras[c].model, system_.intrinsics);
      if (count == 0 || !full_) {
        add(columns.back(), columns.back(), columns.back().jacobian.transpose() * columns.back().jacobian);
        continue;
      }
      Column own{intrinsics_[c], weight * by_intrinsics.leftCols(count), {}};
      own.coupling = own.jacobian.transpose() * by_point;
      const Column& of_pose = columns.back();
      add(of_pose, of_pose, of_pose.jacobian.transpose() * of_pose.jacobian);
      add(of_pose, own, of_pose.jacobian.transpose() * own.jacobian);
      add(own, of_pose, own.jacobian.transpose() * of_pose.jacobian);
      add(own, own, own.jacobian.transpose() * own.jacobian);
      columns.push_back(std::move(own));
    }
    const Eigen::LDLT<Mat3> ldlt(point);
    if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return;
    for (const auto& a : columns) {
      const Eigen::MatrixXd solved = ldlt.solve(a.coupling.transpose());
      for (const auto& b : columns) {
        if (!full_ && &a != &b) continue;
        add(b, a, -(b.coupling * solved));
      }
    }
  }

  void add_prior(std::size_t f) {
    const auto& prior = system_.priors[f];
    const auto& pose = system_.poses[f];
    const Vec3 turn = log_rotation(prior.pose.rotation.transpose() * pose.rotation);
    const Vec3 weights(prior.weight_xy, prior.weight_xy, prior.weight_z);
    const double squared = (prior.weight_rot * turn).squaredNorm() +
                           weights.cwiseProduct(pose.translation - prior.pose.translation).squaredNorm();
    const double doubt =
        system_.prior_loss_scale > 0.0 ? loss_weight(BundleLoss::huber, system_.prior_loss_scale, squared) : 1.0;
    Mat6 information = Mat6::Zero();
    if (prior.weight_rot > 0.0) {
      const Mat3 j = prior.weight_rot * inverse_right_jacobian(turn);
      information.topLeftCorner<3, 3>() = doubt * j.transpose() * j;
    }
    information.bottomRightCorner<3, 3>() = doubt * Mat3(weights.cwiseAbs2().asDiagonal());
    // A direction that nothing holds stays finite.
    information.topLeftCorner<3, 3>().diagonal().array() += 1.0 / (kUnheldTurn * kUnheldTurn);
    information.bottomRightCorner<3, 3>().diagonal().array() += 1.0 / (kUnheldMetres * kUnheldMetres);
    const auto at = 6 * static_cast<Eigen::Index>(f);
    if (full_) matrix_.block<6, 6>(at, at) += information;
    else blocks_[f] += information;
  }

  const BundleSystem& system_;
  bool full_;
  Eigen::Index size_ = 0;
  std::vector<Eigen::Index> intrinsics_;
  Matrix matrix_;
  std::vector<Mat6> blocks_;
};

// Columns: what a small shift, turn and scale of the world does to the increments.
Matrix gauge_directions(const BundleSystem& system, Eigen::Index size) {
  Vec3 middle = Vec3::Zero();
  for (const auto& pose : system.poses) middle += pose.translation / static_cast<double>(system.poses.size());
  Matrix g = Matrix::Zero(size, 7);
  for (std::size_t f = 0; f < system.poses.size(); ++f) {
    const auto at = 6 * static_cast<Eigen::Index>(f);
    const Vec3 c = system.poses[f].translation - middle;
    g.block<3, 3>(at, 3) = system.poses[f].rotation.transpose();
    g.block<3, 3>(at + 3, 0).setIdentity();
    g.block<3, 3>(at + 3, 3) << 0.0, c.z(), -c.y(), -c.z(), 0.0, c.x(), c.y(), -c.x(), 0.0;
    g.block<3, 1>(at + 3, 6) = c;
  }
  return g;
}

// The same where the alignment looks: shift and scale at the positions, turn at the positions or at the rotations.
Matrix constraint_rows(Matrix g, std::size_t poses, PoseConstraint constraint) {
  for (std::size_t f = 0; f < poses; ++f) {
    const auto at = 6 * static_cast<Eigen::Index>(f);
    if (constraint == PoseConstraint::positions) g.block<3, 7>(at, 0).setZero();
    else g.block<3, 3>(at + 3, 3).setZero();
  }
  return g;
}

}  // namespace

std::vector<Mat6> pose_covariances(const BundleSystem& system, PoseConstraint constraint, bool full) {
  Normal normal(system, full);
  std::vector<Mat6> covariances(system.poses.size(), Mat6::Zero());
  if (!full) {
    for (std::size_t f = 0; f < covariances.size(); ++f) covariances[f] = normal.blocks()[f].inverse();
    return covariances;
  }
  Matrix& n = normal.matrix();
  // Metres, radians and pixels differ by orders of magnitude: to unit diagonal first.
  Eigen::VectorXd scale = n.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  Matrix g, constraints;
  if (constraint != PoseConstraint::none) {
    g = gauge_directions(system, normal.size());
    constraints = constraint_rows(g, system.poses.size(), constraint);
    for (Eigen::Index j = 0; j < constraints.cols(); ++j)
      constraints.col(j) /= (scale.asDiagonal() * constraints.col(j)).norm();  // as heavy as the observations
  }
  Matrix scaled = scale.asDiagonal() * n * scale.asDiagonal();
  if (constraints.size() > 0) {
    const Matrix b = scale.asDiagonal() * constraints;
    scaled += b * b.transpose();
  }
  const Eigen::LLT<Matrix> llt(scaled);
  Matrix inverse = llt.solve(Matrix::Identity(scaled.rows(), scaled.cols()));
  inverse = scale.asDiagonal() * inverse * scale.asDiagonal();
  if (constraints.size() > 0) {
    const Matrix b_g = constraints.transpose() * g;
    const Matrix middle = (b_g.transpose() * b_g).inverse();
    inverse -= g * middle * g.transpose();
  }
  for (std::size_t f = 0; f < covariances.size(); ++f) {
    const auto at = 6 * static_cast<Eigen::Index>(f);
    const Mat6 block = inverse.block<6, 6>(at, at);
    covariances[f] = 0.5 * (block + block.transpose());
  }
  return covariances;
}

}  // namespace cairn::adjustment
