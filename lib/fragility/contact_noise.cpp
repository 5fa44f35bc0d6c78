#include "fragility/contact_noise.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::fragility {

ContactNoise::ContactNoise(const std::vector<ContactVertex>& contact, double correlation, double common_share)
    : common_(std::sqrt(common_share)), local_(std::sqrt(1.0 - common_share)) {
  outwards_.resize(contact.size(), geometry::Vec3::UnitX());
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
    fill_outwards(contact, pad, at, length, correlation);
  }
}

// Across the chord from `reach` behind to `reach` ahead, so that noise of single vertices does not turn it; away from
// the pad's middle.
void ContactNoise::fill_outwards(const std::vector<ContactVertex>& contact, const Pad& pad,
                                 const std::vector<double>& at, double length, double reach) {
  using geometry::Vec3;
  const Vec3 middle = middle_of(contact, pad);
  const std::size_t count = at.size();
  const double step = std::min(reach, length / 8.0);
  // Vertex that lies at least `step` away along the closed line, forwards or backwards.
  const auto away = [&](std::size_t i, std::size_t direction) {
    std::size_t j = i;
    for (std::size_t walked = 0; walked < count; ++walked) {
      j = (j + direction) % count;
      double apart = std::abs(at[i] - at[j]);
      apart = std::min(apart, length - apart);
      if (apart >= step * (1.0 - 1e-9)) break;
    }
    return contact[pad.first + j].position;
  };
  for (std::size_t i = 0; i < count; ++i) {
    Vec3 radial = contact[pad.first + i].position - middle;
    radial.z() = 0.0;
    Vec3 normal = radial;
    if (count > 2) {
      const Vec3 chord = away(i, 1) - away(i, count - 1);
      normal = Vec3(chord.y(), -chord.x(), 0.0);
      if (!(normal.norm() > 1e-9 * length)) normal = radial;
    }
    if (normal.dot(radial) < 0.0) normal = -normal;
    if (normal.norm() > 0.0) outwards_[pad.first + i] = normal.normalized();
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
