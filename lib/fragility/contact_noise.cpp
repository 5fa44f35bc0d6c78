#include "fragility/contact_noise.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::fragility {

ContactNoise::ContactNoise(const std::vector<ContactVertex>& contact, double correlation, double common_share)
    : common_(std::sqrt(common_share)), local_(std::sqrt(1.0 - common_share)) {
  using geometry::Vec3;
  outwards_.resize(contact.size(), Vec3::UnitX());
  // White noise under a Gaussian kernel of width w has a Gaussian correlation of width sqrt(2) w.
  const double width = correlation / std::sqrt(2.0);
  for (const auto& pad : pads_of(contact)) {
    double length = 0.0;
    const auto at = arc_lengths(contact, pad, length);
    constexpr int kMostKnots = 256;
    const int knots = std::clamp(static_cast<int>(std::ceil(1.5 * length / width)), 3, kMostKnots);
    PadBasis basis;
    basis.first = pad.first;
    basis.weights.resize(static_cast<Eigen::Index>(at.size()), knots);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      for (int k = 0; k < knots; ++k) {
        double apart = std::abs(at[i] - length * k / knots);
        apart = std::min(apart, length - apart);
        basis.weights(row, k) = std::exp(-0.5 * apart * apart / (width * width));
      }
      const double norm = basis.weights.row(row).norm();
      if (norm > 0.0) basis.weights.row(row) /= norm;
    }
    pads_.push_back(std::move(basis));
    const Vec3 middle = middle_of(contact, pad);
    for (std::size_t i = pad.first; i < pad.last; ++i) {
      Vec3 d = contact[i].position - middle;
      d.z() = 0.0;
      if (d.norm() > 0.0) outwards_[i] = d.normalized();
    }
  }
}

ContactNoise::Draw ContactNoise::draw(base::Random& random) const {
  Draw draw;
  const auto fill = [&](Eigen::VectorXd& values) {
    values.resize(static_cast<Eigen::Index>(outwards_.size()));
    for (const auto& pad : pads_) {
      const double common = common_ * random.normal();
      Eigen::VectorXd knots(pad.weights.cols());
      for (auto& k : knots) k = random.normal();
      values.segment(static_cast<Eigen::Index>(pad.first), pad.weights.rows()) =
          (local_ * (pad.weights * knots)).array() + common;
    }
  };
  fill(draw.out);
  fill(draw.up);
  return draw;
}

}  // namespace cairn::fragility
