// Random contact lines around a digitised one: errors across the line, correlated along it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/random.hpp"
#include "fragility/contact_line.hpp"

namespace cairn::fragility {

// Position errors of a contact in units of its standard deviation: a part common to a pad (a line that was
// drawn too far out all round) and a local part, Gaussian over the arc length. Two components: across the line in plan,
// outwards, and up.
class ContactNoise {
 public:
  // correlation [m] > 0: distance along the line at which the local part's correlation is exp(-1/2); common_share 0..1
  // of the variance. contact sorted; its lines are taken as closed.
  ContactNoise(const std::vector<ContactVertex>& contact, double correlation, double common_share);

  struct Draw {
    Eigen::VectorXd out, up;  // unit variance, a value a vertex
  };
  // Takes the same count of random numbers every time. Cost vertices x knots.
  [[nodiscard]] Draw draw(base::Random& random) const;

  // Unit vectors in plan, across the line and away from the pad's middle.
  [[nodiscard]] const std::vector<geometry::Vec3>& outwards() const { return outwards_; }

 private:
  struct PadBasis {
    std::size_t first = 0;
    Eigen::MatrixXd weights;  // vertices x knots, rows of unit length
  };
  void fill_outwards(const std::vector<ContactVertex>& contact, const Pad& pad, const std::vector<double>& at,
                     double length, double reach);

  std::vector<PadBasis> pads_;
  std::vector<geometry::Vec3> outwards_;
  double common_ = 0.0, local_ = 1.0;
};

}  // namespace cairn::fragility
