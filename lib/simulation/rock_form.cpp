#include "simulation/rock_form.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulation/noise.hpp"

namespace cairn::simulation {
namespace {

using geometry::Vec3;

Vec3 direction_near(const Vec3& axis, double spread, base::Random& random) {
  return (axis + spread * Vec3(random.normal(), random.normal(), random.normal())).normalized();
}

// Evenly spread directions (Fibonacci's spiral).
Vec3 spiral(int i, int count) {
  const double z = 1.0 - (2.0 * i + 1.0) / count, s = std::sqrt(1.0 - z * z);
  const double turn = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
  return {s * std::cos(turn), s * std::sin(turn), z};
}

// Along a ray from inside: the far root of |(t u - c) / a| = 1.
double leave_ellipsoid(const Vec3& u, const Vec3& centre, const Vec3& semi_axes) {
  const Vec3 d = u.cwiseQuotient(semi_axes), o = -centre.cwiseQuotient(semi_axes);
  const double a = d.squaredNorm(), b = d.dot(o), c = o.squaredNorm() - 1.0;
  return (-b + std::sqrt(std::max(0.0, b * b - a * c))) / a;
}

}  // namespace

RockForm::RockForm(std::string_view family, double irregularity, base::Random& random) : seed_(random.bits()) {
  const double wild = irregularity;
  roughness_ = 0.012 + 0.03 * wild;
  swell_frequency_ = random.uniform(1.0, 1.6);
  if (family == "rounded") {
    balls_.push_back({Vec3::Zero(), Vec3(1.0, 1.0, 1.0)});
    swell_ = 0.06 + 0.42 * wild;
  } else if (family == "angular") {
    const int faces = 14 + static_cast<int>(random.below(9));
    for (int i = 0; i < faces; ++i)
      faces_.push_back(
          {direction_near(spiral(i, faces), 0.1 + 0.25 * wild, random), 1.0 - random.uniform(0.0, 0.1 + 0.3 * wild)});
    sharpness_ = random.uniform(22.0, 40.0);
    swell_ = 0.04 * wild;
    roughness_ *= 0.5;
  } else if (family == "slab") {
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {-1.0, 1.0})
        faces_.push_back({direction_near(sign * Vec3(Vec3::Unit(axis)), 0.04 + 0.14 * wild, random),
                          axis == 2 ? 0.8 : 1.0 - random.uniform(0.0, 0.25 * wild)});
    const int bevels = 3 + static_cast<int>(random.below(4));
    for (int i = 0; i < bevels; ++i) {
      const double turn = random.uniform(0.0, 2.0 * std::numbers::pi);
      faces_.push_back(
          {Vec3(std::cos(turn), std::sin(turn), random.uniform(-0.5, 0.6)).normalized(), random.uniform(0.9, 1.15)});
    }
    sharpness_ = random.uniform(10.0, 18.0);
    swell_ = 0.04 + 0.1 * wild;
    groove_depth_ = 0.03 + 0.05 * wild;
    groove_spacing_ = random.uniform(0.45, 0.8);
    groove_phase_ = random.uniform();
  } else if (family == "pear") {
    const double lean = random.uniform(0.0, 2.0 * std::numbers::pi), shift = 0.12 * wild;
    balls_.push_back({Vec3(shift * std::cos(lean), shift * std::sin(lean), random.uniform(0.3, 0.42)),
                      Vec3(0.95, 0.95, random.uniform(0.7, 0.85))});
    balls_.push_back({Vec3(0.0, 0.0, -0.42), Vec3(0.5, 0.5, 0.75)});
    swell_ = 0.04 + 0.26 * wild;
  } else {  // stacked
    const double lean = random.uniform(0.0, 2.0 * std::numbers::pi), shift = 0.05 + 0.2 * wild;
    const double upper = random.uniform(0.62, 0.85), narrow = 1.0 - 0.3 * wild * random.uniform();
    balls_.push_back({Vec3(shift * std::cos(lean), shift * std::sin(lean), 0.42), Vec3(upper, narrow * upper, 0.56)});
    balls_.push_back({Vec3(0.0, 0.0, -0.42), Vec3(1.0, 1.0 - 0.25 * wild * random.uniform(), 0.55)});
    swell_ = 0.06 + 0.36 * wild;
  }
}

// The ray leaves the half-space with normal n at d / (u.n); a high norm of the inverse distances takes the nearest
// of them with its edges blunted.
double RockForm::blunt_polyhedron(const Vec3& u) const {
  double sum = 0.0;
  for (const HalfSpace& face : faces_) {
    const double inverse = u.dot(face.normal) / face.distance;
    if (inverse > 0.0) sum += std::pow(inverse, sharpness_);
  }
  return std::pow(std::max(sum, 1e-12), -1.0 / sharpness_);
}

double RockForm::blended_balls(const Vec3& u) const {
  constexpr double kBlend = 18.0;  // a soft maximum: necks are rounded over a twentieth of the size
  double sum = 0.0;
  for (const Ball& ball : balls_) sum += std::exp(kBlend * leave_ellipsoid(u, ball.centre, ball.semi_axes));
  return std::log(sum) / kBlend;
}

double RockForm::radius(const Vec3& u) const {
  double r = faces_.empty() ? blended_balls(u) : blunt_polyhedron(u);
  if (swell_ > 0.0) r *= 1.0 + swell_ * fractal_noise(swell_frequency_ * u + Vec3::Constant(7.3), seed_, 3, 0.45);
  // Fine relief is taken at the point, not the direction, so that flat faces keep one grain.
  r *= 1.0 + roughness_ * fractal_noise(5.0 * r * u, seed_ + 101, 4, 0.55);
  if (groove_depth_ > 0.0) {
    const double bed = r * u.z() / groove_spacing_ + groove_phase_ + 0.12 * value_noise(1.5 * u, seed_ + 202);
    const double from_joint = std::abs(bed - std::round(bed)) * groove_spacing_ / 0.06;
    // Only where the surface is steep: a groove in a flat top would be a hole.
    r *= 1.0 - groove_depth_ * std::exp(-from_joint * from_joint) * (1.0 - u.z() * u.z());
  }
  return std::max(r, 0.05);
}

}  // namespace cairn::simulation
