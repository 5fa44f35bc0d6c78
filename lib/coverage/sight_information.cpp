#include "coverage/sight_information.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "base/angle.hpp"

namespace cairn::coverage {

ViewNoise view_noise(const View& view, const NoiseOptions& options) {
  const auto stated = [](double value, double otherwise) { return value > 0.0 ? value : otherwise; };
  const auto variance = [](double sigma) { return static_cast<float>(sigma * sigma); };
  return {variance(options.pixel_sigma_px), variance(stated(view.sigma_xy_m, options.position_sigma_m)),
          variance(stated(view.sigma_z_m, options.position_sigma_m)),
          variance(base::deg_to_rad(stated(view.sigma_rot_deg, options.rotation_sigma_deg)))};
}

PointSigma point_sigma(const Information& information) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const auto [xx, xy, xz, yy, yz, zz] = information;
  // Scaled to a trace of 3, so that the determinant is a pure number.
  const double scale = (xx + yy + zz) / 3.0;
  if (!(scale > 0.0) || !std::isfinite(scale)) return {kNone, kNone};
  const double a = xx / scale, b = xy / scale, c = xz / scale, d = yy / scale, e = yz / scale, f = zz / scale;
  const double det = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d);
  constexpr double kSingular = 1e-12;  // what single-precision sight lines leave of a determinant of zero
  if (!(det > kSingular)) return {kNone, kNone};
  geometry::Mat3 adjugate;
  adjugate << d * f - e * e, c * e - b * f, b * e - c * d,  //
      c * e - b * f, a * f - c * c, b * c - a * e,          //
      b * e - c * d, b * c - a * e, a * d - b * b;
  Eigen::SelfAdjointEigenSolver<geometry::Mat3> solver;
  solver.computeDirect(adjugate, Eigen::EigenvaluesOnly);
  const double unit = 1.0 / (det * scale);
  return {std::sqrt(solver.eigenvalues()[2] * unit), std::sqrt(adjugate(2, 2) * unit)};
}

}  // namespace cairn::coverage
