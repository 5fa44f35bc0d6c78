#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "localisation/body_solver.hpp"

namespace cairn::localisation {
namespace {

using geometry::Vec3;
constexpr int kParameters = static_cast<int>(kBodyParameters);
constexpr double kNearest = 1e-3;  // m in front of the camera
constexpr int kMostIterations = 100;
constexpr double kLeastCondition = 1e-13;  // smallest / largest eigenvalue of the scaled normal matrix

template <typename T>
bool raw_residuals(const BoxPlanes& box, const T* x, T* residual) {
  const T depth = (x[0] - box.camera.x()) * box.forward.x() + (x[1] - box.camera.y()) * box.forward.y() +
                  (x[2] - box.camera.z()) * box.forward.z();
  if (!(depth > T(kNearest))) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    if (!box.used[i]) {
      residual[i] = T(0.0);
      continue;
    }
    const Vec3& n = box.normal[i];
    const T along = (x[0] - box.camera.x()) * n.x() + (x[1] - box.camera.y()) * n.y() + (x[2] - box.camera.z()) * n.z();
    residual[i] = (along + T(kSideSign[i]) * support(x, n)) / depth;
  }
  return true;
}

struct RawSides {
  const BoxPlanes* box;
  template <typename T>
  bool operator()(const T* x, T* residual) const {
    return raw_residuals(*box, x, residual);
  }
};

struct WhitenedSides {
  const BoxPlanes* box;
  template <typename T>
  bool operator()(const T* x, T* residual) const {
    T raw[4];
    if (!raw_residuals(*box, x, raw)) return false;
    for (int i = 0; i < 4; ++i) {
      residual[i] = T(0.0);
      for (int j = 0; j <= i; ++j) residual[i] += T(box->whitener(i, j)) * raw[j];
    }
    return true;
  }
};

struct Prior {
  const BodyPrior* prior;
  template <typename T>
  bool operator()(const T* x, T* residual) const {
    for (std::size_t i = 0; i < kBodyParameters; ++i) {
      const double sigma = prior->sigma[i];
      T value = x[i];
      if (i == kLogHalfHeight) value -= x[kLogRadius];
      residual[i] = sigma > 0.0 ? (value - T(prior->mean[i])) / T(sigma) : T(0.0);
    }
    return true;
  }
};

}  // namespace

bool side_residuals(const BoxPlanes& box, const BodyParameters& x, Eigen::Vector4d* residual, SideJacobian* jacobian) {
  const ceres::AutoDiffCostFunction<RawSides, 4, kParameters> cost(new RawSides{&box});
  const double* blocks[] = {x.data()};
  double* jacobians[] = {jacobian != nullptr ? jacobian->data() : nullptr};
  return cost.Evaluate(blocks, residual->data(), jacobian != nullptr ? jacobians : nullptr);
}

BodySolution solve_body(std::span<const BoxPlanes> boxes, const BodyParameters& start, const BodyPrior& prior,
                        double scale) {
  BodySolution result;
  result.x = start;
  result.normal.setZero();
  ceres::CauchyLoss loss(scale);
  ceres::Problem::Options own;
  own.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(own);
  double* x = result.x.data();
  problem.AddParameterBlock(x, kParameters);
  std::vector<int> fixed;
  for (int i = 0; i < kParameters; ++i)
    if (prior.sigma[static_cast<std::size_t>(i)] < 0.0) {
      fixed.push_back(i);
      x[i] = prior.mean[static_cast<std::size_t>(i)];
    }
  if (!fixed.empty()) problem.SetManifold(x, new ceres::SubsetManifold(kParameters, fixed));
  for (const auto& box : boxes) {
    Eigen::Vector4d residual;
    if (!side_residuals(box, result.x, &residual, nullptr) || !residual.allFinite()) {
      result.failure = "fit_behind_camera";
      return result;
    }
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<WhitenedSides, 4, kParameters>(new WhitenedSides{&box}),
                             &loss, x);
  }
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, kParameters, kParameters>(new Prior{&prior}), nullptr,
                           x);

  ceres::Solver::Options options;
  options.num_threads = 1;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = kMostIterations;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-10;
  options.gradient_tolerance = 1e-12;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  result.iterations = static_cast<int>(summary.iterations.size());
  bool finite = true;
  for (const double value : result.x) finite = finite && std::isfinite(value);
  if (!finite || summary.termination_type != ceres::CONVERGENCE) {
    result.failure = "fit_not_converged";
    return result;
  }

  for (const auto& box : boxes) {
    Eigen::Vector4d residual;
    SideJacobian jacobian;
    if (!side_residuals(box, result.x, &residual, &jacobian) || !residual.allFinite() || !jacobian.allFinite()) {
      result.failure = "fit_behind_camera";
      return result;
    }
    double rho[3];
    loss.Evaluate((box.whitener * residual).squaredNorm(), rho);
    const SideJacobian whitened = box.whitener * jacobian;
    result.normal += rho[1] * whitened.transpose() * whitened;
    result.weight.push_back(rho[1]);
    result.residual.push_back(residual);
    result.jacobian.push_back(jacobian);
  }
  for (std::size_t i = 0; i < kBodyParameters; ++i) {
    if (!(prior.sigma[i] > 0.0)) continue;
    Eigen::Matrix<double, kParameters, 1> row = Eigen::Matrix<double, kParameters, 1>::Zero();
    row[static_cast<int>(i)] = 1.0 / prior.sigma[i];
    if (i == kLogHalfHeight) row[kLogRadius] = -1.0 / prior.sigma[i];
    result.normal += row * row.transpose();
  }
  for (const int i : fixed) {
    result.normal.row(i).setZero();
    result.normal.col(i).setZero();
    result.normal(i, i) = 1e30;
  }
  // Scaled to a unit diagonal, so that metres and logarithms can be compared.
  const Eigen::Matrix<double, kParameters, 1> diagonal = result.normal.diagonal();
  if (!result.normal.allFinite() || !(diagonal.minCoeff() > 0.0)) {
    result.failure = "fit_singular";
    return result;
  }
  const auto inverse_root = diagonal.cwiseSqrt().cwiseInverse().eval();
  const BodyMatrix scaled = inverse_root.asDiagonal() * result.normal * inverse_root.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<BodyMatrix> eigen(scaled, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues().minCoeff() > kLeastCondition * eigen.eigenvalues().maxCoeff()))
    result.failure = "fit_singular";
  return result;
}

}  // namespace cairn::localisation
