#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "localisation/body_solver.hpp"

namespace cairn::localisation {
namespace {

using geometry::Vec3;
constexpr int kEllipsoid = static_cast<int>(kEllipsoidParameters);
constexpr double kNearest = 1e-3;  // m in front of the camera
constexpr int kMostIterations = 100;
constexpr int kCorrections = 8;            // Gauss-Newton steps with the harmonics
constexpr double kSettled = 1e-8;          // largest step, m and relative
constexpr double kLeastCondition = 1e-13;  // smallest / largest eigenvalue of the scaled normal matrix

template <typename T>
bool ellipsoid_residuals(const BoxPlanes& box, const T* x, T* residual) {
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
    residual[i] = (along + T(kSideSign[i]) * ellipsoid_support(x, n)) / depth;
  }
  return true;
}

struct WhitenedSides {
  const BoxPlanes* box;
  template <typename T>
  bool operator()(const T* x, T* residual) const {
    T raw[4];
    if (!ellipsoid_residuals(*box, x, raw)) return false;
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
    for (int i = 0; i < kEllipsoid; ++i) {
      const double sigma = prior->sigma[i];
      T value = x[i];
      if (i == kLogHalfHeight) value -= x[kLogRadius];
      residual[i] = sigma > 0.0 ? (value - T(prior->mean[i])) / T(sigma) : T(0.0);
    }
    return true;
  }
};

std::string fit_ellipsoid(std::span<const BoxPlanes> boxes, const BodyPrior& prior, double scale,
                          BodySolution& result) {
  ceres::CauchyLoss loss(scale);
  ceres::Problem::Options own;
  own.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(own);
  double* x = result.body.ellipsoid.data();
  problem.AddParameterBlock(x, kEllipsoid);
  for (const auto& box : boxes)
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<WhitenedSides, 4, kEllipsoid>(new WhitenedSides{&box}),
                             &loss, x);
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Prior, kEllipsoid, kEllipsoid>(new Prior{&prior}), nullptr,
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
  for (const double value : result.body.ellipsoid)
    if (!std::isfinite(value)) return "fit_not_converged";
  return summary.termination_type == ceres::CONVERGENCE ? "" : "fit_not_converged";
}

// Residuals, weights and normal equations at the present body; gradient of the cost.
bool linearise(std::span<const BoxPlanes> boxes, const BodyPrior& prior, const ceres::LossFunction& loss,
               BodySolution& s, BodyVector* gradient) {
  s.normal.setZero();
  gradient->setZero();
  s.weight.clear();
  s.residual.clear();
  s.jacobian.clear();
  for (const auto& box : boxes) {
    Eigen::Vector4d residual;
    SideJacobian jacobian;
    if (!side_residuals(box, s.body, &residual, &jacobian) || !residual.allFinite() || !jacobian.allFinite())
      return false;
    const Eigen::Vector4d white = box.whitener * residual;
    double rho[3];
    loss.Evaluate(white.squaredNorm(), rho);
    const SideJacobian whitened = box.whitener * jacobian;
    s.normal.noalias() += rho[1] * whitened.transpose() * whitened;
    *gradient += rho[1] * whitened.transpose() * white;
    s.weight.push_back(rho[1]);
    s.residual.push_back(residual);
    s.jacobian.push_back(jacobian);
  }
  for (Eigen::Index i = 0; i < kEllipsoid; ++i) {
    if (!(prior.sigma[i] > 0.0)) continue;
    BodyVector row = BodyVector::Zero();
    row[i] = 1.0 / prior.sigma[i];
    double value = s.body.ellipsoid[static_cast<std::size_t>(i)];
    if (i == kLogHalfHeight) {
      row[kLogRadius] = -1.0 / prior.sigma[i];
      value -= s.body.ellipsoid[kLogRadius];
    }
    s.normal += row * row.transpose();
    *gradient += row * ((value - prior.mean[i]) / prior.sigma[i]);
  }
  constexpr int kCount = static_cast<int>(kHarmonics);
  const Eigen::Map<const Eigen::Matrix<double, kCount, 1>> harmonic(s.body.harmonic.data());
  s.normal.bottomRightCorner<kCount, kCount>() += prior.harmonic_information;
  gradient->tail<kCount>() += prior.harmonic_information * (harmonic - prior.harmonic_mean);
  return true;
}

bool well_conditioned(const BodyMatrix& normal) {
  const BodyVector diagonal = normal.diagonal();
  if (!normal.allFinite() || !(diagonal.minCoeff() > 0.0)) return false;
  // Scaled to a unit diagonal, so that metres and logarithms can be compared.
  const BodyVector root = diagonal.cwiseSqrt().cwiseInverse();
  const BodyMatrix scaled = root.asDiagonal() * normal * root.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<BodyMatrix> eigen(scaled, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues().minCoeff() > kLeastCondition * eigen.eigenvalues().maxCoeff();
}

}  // namespace

double Body::support(const Vec3& n) const {
  const Vec3 m = normalised(ellipsoid.data(), n);
  const double length = m.norm();
  if (!(length > 0.0)) return 0.0;
  std::array<double, kHarmonics> y;
  harmonics<double>(m / length, &y);
  double sum = 1.0;
  for (std::size_t i = 0; i < kHarmonics; ++i) sum += harmonic[i] * y[i];
  return length * sum;
}

bool side_residuals(const BoxPlanes& box, const Body& body, Eigen::Vector4d* residual, SideJacobian* jacobian) {
  using Jet = ceres::Jet<double, kEllipsoid>;
  std::array<Jet, kEllipsoidParameters> x;
  for (int i = 0; i < kEllipsoid; ++i)
    x[static_cast<std::size_t>(i)] = Jet(body.ellipsoid[static_cast<std::size_t>(i)], i);
  const auto dot = [&](const Vec3& v) {
    return (x[0] - box.camera.x()) * v.x() + (x[1] - box.camera.y()) * v.y() + (x[2] - box.camera.z()) * v.z();
  };
  const Jet depth = dot(box.forward);
  if (!(depth.a > kNearest)) return false;
  residual->setZero();
  if (jacobian != nullptr) jacobian->setZero();
  for (std::size_t i = 0; i < 4; ++i) {
    if (!box.used[i]) continue;
    const Vec3& n = box.normal[i];
    // The least of n.p over the body is that of -n, turned round.
    const Eigen::Matrix<Jet, 3, 1> m = normalised(x.data(), Vec3(kSideSign[i] * n));
    const Jet length = sqrt(m.x() * m.x() + m.y() * m.y() + m.z() * m.z());
    std::array<Jet, kHarmonics> y;
    harmonics<Jet>({m.x() / length, m.y() / length, m.z() / length}, &y);
    Jet sum(1.0);
    for (std::size_t k = 0; k < kHarmonics; ++k) sum += body.harmonic[k] * y[k];
    const Jet r = (dot(n) + kSideSign[i] * length * sum) / depth;
    const auto row = static_cast<Eigen::Index>(i);
    (*residual)[row] = r.a;
    if (jacobian == nullptr) continue;
    jacobian->block<1, kEllipsoid>(row, 0) = r.v.transpose();
    for (std::size_t k = 0; k < kHarmonics; ++k)
      (*jacobian)(row, kEllipsoid + static_cast<Eigen::Index>(k)) = kSideSign[i] * length.a * y[k].a / depth.a;
  }
  return true;
}

BodySolution solve_body(std::span<const BoxPlanes> boxes, const Body& start, const BodyPrior& prior, double scale) {
  BodySolution s;
  s.body = start;
  s.body.harmonic.fill(0.0);
  for (const auto& box : boxes) {
    Eigen::Vector4d residual;
    if (!side_residuals(box, s.body, &residual, nullptr) || !residual.allFinite()) {
      s.failure = "fit_behind_camera";
      return s;
    }
  }
  s.failure = fit_ellipsoid(boxes, prior, scale, s);
  if (!s.failure.empty()) return s;
  const ceres::CauchyLoss loss(scale);
  BodyVector gradient;
  for (int step = 0; step <= kCorrections; ++step) {
    if (!linearise(boxes, prior, loss, s, &gradient)) {
      s.failure = "fit_behind_camera";
      return s;
    }
    if (step == kCorrections) break;
    const BodyVector move = -s.normal.ldlt().solve(gradient);
    if (!move.allFinite()) {
      s.failure = "fit_singular";
      return s;
    }
    for (std::size_t i = 0; i < kEllipsoidParameters; ++i) s.body.ellipsoid[i] += move[static_cast<Eigen::Index>(i)];
    for (std::size_t i = 0; i < kHarmonics; ++i) s.body.harmonic[i] += move[kEllipsoid + static_cast<Eigen::Index>(i)];
    if (move.cwiseAbs().maxCoeff() < kSettled) break;
  }
  if (!well_conditioned(s.normal)) s.failure = "fit_singular";
  return s;
}

}  // namespace cairn::localisation
