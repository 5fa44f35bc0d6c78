#include "localisation/body_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/angle.hpp"
#include "base/parallel.hpp"
#include "localisation/body_work.hpp"

namespace cairn::localisation {
namespace {

using geometry::Mat2;
using geometry::Mat3;
using geometry::PixelBox;
using geometry::Vec2;
using geometry::Vec3;
using survey::Target;
using Mat4 = Eigen::Matrix4d;

struct Noise {
  double box = 1.0, pose = 1.0;  // factors on the assumed sigmas
};

constexpr std::array<int, 4> kAxis{0, 1, 0, 1};  // u or v of a side

Mat4 side_covariance(const SeenBox& box, const Noise& noise) {
  Mat4 c;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      c(i, j) =
          (i == j ? noise.box * noise.box * box.side_variance : 0.0) +
          noise.pose * noise.pose * box.pose(kAxis[static_cast<std::size_t>(i)], kAxis[static_cast<std::size_t>(j)]);
  return c;
}

// Inverse of the lower Cholesky factor over the used sides; zero elsewhere.
Mat4 whitener(const BoxPlanes& planes, const Mat4& covariance) {
  std::vector<int> used;
  for (int i = 0; i < 4; ++i)
    if (planes.used[static_cast<std::size_t>(i)]) used.push_back(i);
  const auto n = static_cast<Eigen::Index>(used.size());
  Eigen::MatrixXd sub(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      sub(i, j) = covariance(used[static_cast<std::size_t>(i)], used[static_cast<std::size_t>(j)]);
  const Eigen::MatrixXd inverse = sub.llt().matrixL().solve(Eigen::MatrixXd(Eigen::MatrixXd::Identity(n, n)));
  Mat4 result = Mat4::Zero();
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      result(used[static_cast<std::size_t>(i)], used[static_cast<std::size_t>(j)]) = inverse(i, j);
  return result;
}

// What rocks are, by degree 3 to 6 of the harmonics: zonal ones (flat undersides, heads wider than feet), which go
// together, and the others. docs/science/localisation.md says how these were measured.
constexpr std::size_t kDegrees = 4;
constexpr std::array<double, kDegrees> kZonalMean{0.0105, -0.0171, 0.0040, -0.0058};
constexpr std::array<double, kDegrees> kZonalSigma{0.0270, 0.0194, 0.0095, 0.0046};
constexpr std::array<std::array<double, kDegrees>, kDegrees> kZonalCorrelation{
    {{1.0, -0.12, -0.73, 0.36}, {-0.12, 1.0, 0.33, -0.61}, {-0.73, 0.33, 1.0, -0.32}, {0.36, -0.61, -0.32, 1.0}}};
constexpr std::array<double, kDegrees> kHarmonicSigma{0.0125, 0.0095, 0.0045, 0.0033};
constexpr double kStretchSigma = 0.25;  // half the log of the ratio of the level axes
constexpr double kHeightSigma = 0.4;    // log of half height over mean level semi-axis
constexpr double kLeanSigma = 0.2;      // of the mean semi-axis
// What degree 6 cannot follow: sharp edges. The middle of the plan by this share of the radius, top and bottom by this
// share of the height (1 sigma); a cut foot's edge lies higher than its smooth continuation by kFootShare.
constexpr double kPlanError = 0.018, kEndError = 0.015, kFootShare = 0.028;
constexpr double kExactly = 1e-7;  // sigma of a harmonic that is held at 0

BodyPrior body_prior(double radius, bool rock) {
  BodyPrior prior;
  prior.sigma[kStretchEast] = prior.sigma[kStretchDiag] = kStretchSigma;
  prior.sigma[kLogHalfHeight] = kHeightSigma;
  prior.sigma[kLeanEast] = prior.sigma[kLeanNorth] = kLeanSigma * radius;
  if (!rock) {
    prior.harmonic_information.diagonal().setConstant(1.0 / (kExactly * kExactly));
    return prior;
  }
  Eigen::Matrix4d zonal;
  for (std::size_t i = 0; i < kDegrees; ++i)
    for (std::size_t j = 0; j < kDegrees; ++j)
      zonal(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          kZonalSigma[i] * kZonalSigma[j] * kZonalCorrelation[i][j];
  const Eigen::Matrix4d information = zonal.inverse();
  const auto at = [](std::size_t degree, int m) {
    return static_cast<Eigen::Index>(harmonic_index(kLeastDegree + static_cast<int>(degree), m));
  };
  for (std::size_t i = 0; i < kDegrees; ++i) {
    const int l = kLeastDegree + static_cast<int>(i);
    prior.harmonic_mean[at(i, 0)] = kZonalMean[i];
    for (std::size_t j = 0; j < kDegrees; ++j)
      prior.harmonic_information(at(i, 0), at(j, 0)) =
          information(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
    for (int m = -l; m <= l; ++m)
      if (m != 0) prior.harmonic_information(at(i, m), at(i, m)) = 1.0 / (kHarmonicSigma[i] * kHarmonicSigma[i]);
  }
  return prior;
}

void solve(BodyWork& work, const Noise& noise, const BodyFitOptions& options) {
  if (!work.reason.empty()) return;
  std::vector<BoxPlanes> planes;
  for (auto& box : work.boxes) {
    box.planes.whitener = whitener(box.planes, side_covariance(box, noise));
    planes.push_back(box.planes);
  }
  work.solution =
      solve_body(planes, work.start, body_prior(std::exp(work.start.ellipsoid[kLogRadius]), options.shape == "rock"),
                 options.loss_scale);
  // The next round starts here.
  if (work.solution.failure.empty()) work.start.ellipsoid = work.solution.body.ellipsoid;
}

// What the residuals of all targets say about the assumed sigmas: the width and height of a box do not depend on the
// pose, its place does. The part of the residuals that the fit has absorbed is allowed for.
Noise observed_noise(const std::vector<BodyWork>& works, const Noise& assumed) {
  double size_seen = 0.0, size_expected = 0.0, place_seen = 0.0, place_box = 0.0, place_pose = 0.0, absorbed = 0.0;
  for (const auto& work : works) {
    const auto& s = work.solution;
    if (!work.reason.empty() || !s.failure.empty()) continue;
    const BodyMatrix covariance = s.normal.llt().solve(BodyMatrix::Identity());
    for (std::size_t i = 0; i < work.boxes.size(); ++i) {
      if (!work.boxes[i].whole || s.weight[i] < 0.5) continue;
      const double side = assumed.box * assumed.box * work.boxes[i].side_variance;
      const Mat4 fitted = s.jacobian[i] * covariance * s.jacobian[i].transpose();
      for (int a = 0; a < 2; ++a) {
        Eigen::Vector4d size = Eigen::Vector4d::Zero(), place = size;
        size[a] = -1.0;
        size[a + 2] = 1.0;
        place[a] = place[a + 2] = 0.5;
        const double ds = size.dot(s.residual[i]), dp = place.dot(s.residual[i]);
        size_seen += ds * ds / side;
        size_expected += 2.0 - size.dot(fitted * size) / side;
        place_seen += dp * dp;
        absorbed += place.dot(fitted * place);
        place_box += 0.5 * side;
        place_pose += assumed.pose * assumed.pose * work.boxes[i].pose(a, a);
      }
    }
  }
  constexpr double kLeast = 0.05, kMost = 20.0, kLeastRedundancy = 20.0;
  Noise noise = assumed;
  if (size_expected < kLeastRedundancy) return noise;
  const double box2 = size_seen / size_expected;
  noise.box *= std::sqrt(std::clamp(box2, kLeast * kLeast, kMost * kMost));
  if (place_pose > 0.0) {
    const double pose2 = (place_seen + absorbed - box2 * place_box) / place_pose;
    noise.pose *= std::sqrt(std::clamp(pose2, 1e-4, kMost * kMost));
  }
  return noise;
}

void finish(const BodyWork& work, const Mat3& covariance, double common_share, const BodyFitOptions& options,
            Target& target) {
  const auto& s = work.solution;
  const std::string& reason = work.reason.empty() ? s.failure : work.reason;
  if (!reason.empty()) {
    target.reasons.push_back(reason);
    return;
  }
  const Mat2 a = half_axis_matrix(s.body.ellipsoid.data());
  const double half_height = std::exp(s.body.ellipsoid[kLogHalfHeight]);
  survey::RefinedBody r;
  const bool rock = options.shape == "rock";
  r.cylinder = cylinder_of(s.body);
  if (rock) r.cylinder.bottom += kFootShare * r.cylinder.height();
  r.cylinder.axis += target.centre.head<2>();
  r.cylinder.bottom += target.centre.z();
  r.cylinder.top += target.centre.z();
  r.centre = r.cylinder.centre();
  r.covariance = covariance;
  if (rock) {
    const double plan = kPlanError * r.cylinder.radius, end = std::sqrt(0.5) * kEndError * r.cylinder.height();
    r.covariance.diagonal() += Vec3(plan * plan, plan * plan, end * end);
  }
  double turn_m = 0.0;
  for (const auto& box : work.boxes) turn_m += box.turn_m / static_cast<double>(work.boxes.size());
  const double common = common_share * turn_m;
  constexpr double kInHeight = 2.0;  // a common tilt cancels around an object, and lifts or lowers it
  r.covariance.diagonal() += Vec3(common * common, common * common, kInHeight * kInHeight * common * common);
  const double aside = options.margin_sigmas * std::sqrt(std::max(r.covariance(0, 0), r.covariance(1, 1)));
  const double above = options.margin_sigmas * std::sqrt(r.covariance(2, 2));
  r.cylinder.radius += aside;
  r.cylinder.bottom -= above;
  r.cylinder.top += above;
  const Eigen::SelfAdjointEigenSolver<Mat2> section(a);
  const Vec2 axis = section.eigenvectors().col(1);
  r.semi_axes_m = Vec3(section.eigenvalues()[1], section.eigenvalues()[0], half_height);
  double azimuth = base::rad_to_deg(std::atan2(axis.x(), axis.y()));
  if (azimuth < 0.0) azimuth += 180.0;
  if (azimuth >= 180.0) azimuth -= 180.0;
  r.azimuth_deg = azimuth;
  double squares = 0.0;
  std::size_t sides = 0;
  for (std::size_t i = 0; i < work.boxes.size(); ++i) {
    if (s.weight[i] < 0.5) {
      ++r.rejected_boxes;
      continue;
    }
    ++r.boxes;
    squares += s.residual[i].squaredNorm();
    sides +=
        static_cast<std::size_t>(std::count(work.boxes[i].planes.used.begin(), work.boxes[i].planes.used.end(), true));
  }
  r.rms_px = sides > 0 ? std::sqrt(squares / static_cast<double>(sides)) : 0.0;
  if (!r.centre.allFinite() || !r.covariance.allFinite() || !std::isfinite(r.rms_px) ||
      !std::isfinite(r.cylinder.radius) || !std::isfinite(r.cylinder.height())) {
    target.reasons.emplace_back("fit_singular");
    return;
  }
  target.refined = r;
}

}  // namespace

void BodyFitOptions::visit(base::OptionVisitor& v) {
  v.real("body-edge-margin-px", edge_margin_px, 0.0, 1e4, "joint fit: box sides nearer to the border are not used");
  v.real("body-sigma-px", sigma_px, 0.01, 1e3, "joint fit: 1 sigma of a box side");
  v.real("body-sigma-size", sigma_size, 0.0, 1.0, "joint fit: 1 sigma of a box side as a fraction of the box's side");
  v.flag("body-assumed-noise", assumed_noise, "joint fit: keep the assumed errors instead of the residuals' own");
  v.real("body-pose-sigma-m", pose_sigma_m, -1.0, 1e3, "joint fit: 1 sigma of a camera position; -1 = by frame");
  v.real("body-pose-sigma-deg", pose_sigma_deg, -1.0, 180.0, "joint fit: 1 sigma of a camera rotation; -1 = by frame");
  v.real("body-common-turn", common_turn, 0.0, 1.0,
         "joint fit: share of the rotations' sigma that all frames of an object have in common");
  v.real("body-loss-scale", loss_scale, 0.5, 1e3, "joint fit: whitened residual at which a box has half its weight");
  v.choice("body-shape", shape, {"rock", "ellipsoid"},
           "joint fit: ellipsoid corrected as rocks are, or ellipsoid only");
  v.real("body-margin-sigmas", margin_sigmas, 0.0, 10.0, "joint fit: the cylinder is this many sigmas larger");
  v.integer("body-max-boxes", max_boxes, 3, 1000000, "joint fit: most boxes of a target that are used");
  v.integer("body-min-boxes", min_boxes, 2, 1000, "joint fit: least boxes of a target");
  v.real("body-min-parallax-deg", min_parallax_deg, 0.0, 180.0, "joint fit: least angle between two rays");
}

BodyFitCounts refine_bodies(std::vector<Target>& targets, const survey::Survey& survey, const BodyFitOptions& options,
                            base::RunContext& ctx) {
  BodyFitOptions checked = options;
  base::validate(base::bind_options(checked), "locate");
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    targets[i].refined.reset();
    if (targets[i].state == survey::TargetState::converged || targets[i].state == survey::TargetState::mapped)
      chosen.push_back(i);
  }
  std::vector<BodyWork> works(chosen.size());
  const auto each = [&](const auto& body) {
    ctx.check_stop();
    base::parallel_for(works.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) body(i);
    });
  };
  Noise noise;
  each([&](std::size_t i) {
    works[i] = prepare_body(targets[chosen[i]], chosen[i], survey, options);
    solve(works[i], noise, options);
  });
  constexpr int kRounds = 3;
  if (!options.assumed_noise)
    for (int round = 0; round < kRounds; ++round) {
      noise = observed_noise(works, noise);
      each([&](std::size_t i) { solve(works[i], noise, options); });
    }
  BodyFitCounts counts;
  counts.box_noise_scale = noise.box;
  counts.pose_noise_scale = noise.pose;
  std::vector<CentreCovariance> covariances(works.size());
  each([&](std::size_t i) { covariances[i] = centre_covariance(works[i]); });
  const double common = common_turn(covariances, options);
  for (std::size_t i = 0; i < works.size(); ++i) {
    Target& target = targets[works[i].target];
    finish(works[i], covariances[i].value, common, options, target);
    if (!target.refined) {
      ++counts.failed;
      continue;
    }
    ++counts.fitted;
    counts.boxes += target.refined->boxes;
    counts.rejected_boxes += target.refined->rejected_boxes;
  }
  return counts;
}

BodyFitCounts refine_bodies(LocateResult& located, const survey::Survey& survey, const BodyFitOptions& options,
                            base::RunContext& ctx) {
  const auto counts = refine_bodies(located.targets, without_drift(survey, located), options, ctx);
  for (std::size_t i = 0; i < located.targets.size(); ++i)
    if (auto& body = located.targets[i].refined) body->covariance += located.evidence[i].drift_covariance;
  return counts;
}

}  // namespace cairn::localisation
