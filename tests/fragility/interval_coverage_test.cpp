// Whether the intervals are honest: on generated rocks with known rims, seen with errors that are not drawn from the
// model's own.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "base/angle.hpp"
#include "fragility/contact_line.hpp"
#include "fragility/monte_carlo.hpp"
#include "fragility/subjects.hpp"
#include "fragility/tipping.hpp"
#include "simulation/shape.hpp"
#include "support/bodies.hpp"

namespace cairn::fragility {
namespace {

using geometry::Vec3;
using testing::closed_pad;

struct Truth {
  simulation::Shape shape;
  geometry::MassProperties mass;
  TippingResult on_rim;
};

Truth make_rock(std::uint64_t seed) {
  base::Random random(seed, "interval coverage", 0);
  simulation::ShapeSpec spec;
  spec.size_m = {random.uniform(0.7, 1.4), random.uniform(0.6, 1.2), random.uniform(0.8, 2.5)};
  spec.tilt_deg = random.uniform(0.0, 8.0);
  spec.edge_m = 0.08;
  Truth truth;
  truth.shape = simulation::make_shape(spec, random);
  truth.mass = geometry::mass_properties(truth.shape.body);
  truth.on_rim = tipping(truth.mass, truth.shape.contact_rim.front(), 1e-6);
  return truth;
}

// The rim as a survey might give it: sampled every 2 cm, each point off by itself, the line out or in all round (a
// label boundary has a bias), and a slow wave round it. Total standard deviation `sigma`.
survey::Contact seen_rim(const Truth& truth, double sigma, base::Random& random) {
  auto line = densified(closed_pad(truth.shape.contact_rim.front()), 0.02, 2000);
  const auto pad = pads_of(line).front();
  const Vec3 middle = middle_of(line, pad);
  const double common = std::sqrt(0.5) * random.normal(), wave = std::sqrt(0.3) * std::sqrt(2.0) * random.normal();
  const double phase = random.uniform(0.0, 2.0 * std::numbers::pi);
  for (auto& v : line) {
    Vec3 out = v.position - middle;
    out.z() = 0.0;
    const double turn = 3.0 * std::atan2(out.y(), out.x()) + phase;
    const double error = common + wave * std::cos(turn) + std::sqrt(0.2) * random.normal();
    v.position += sigma * error * out.normalized() + Vec3(0, 0, 0.5 * sigma * random.normal());
    v.sigma_m = sigma;
  }
  return line;
}

TEST(IntervalCoverage, NinetyPercentIntervalOfAlphaOnTheRim) {
  constexpr std::uint64_t kRocks = 150;
  constexpr double kSigma = 0.015;  // m
  int standing = 0, covered = 0, below = 0;
  double width = 0.0, bias = 0.0;
  for (std::uint64_t seed = 0; seed < kRocks; ++seed) {
    const auto truth = make_rock(seed);
    if (truth.on_rim.equilibrium != Equilibrium::stable) continue;
    base::Random errors(seed, "survey errors", 1);
    MonteCarloInput input;
    input.mesh = &truth.shape.body;
    input.mass = truth.mass;
    input.noise_m = 0.005;
    input.contact = seen_rim(truth, kSigma, errors);
    // A base closed a little too high or too low, and the vertical a little off.
    input.mass.centre_of_mass.z() += 0.005 * errors.normal();
    input.mass.centre_of_mass.x() += 0.004 * errors.normal();
    input.mass.centre_of_mass.y() += 0.004 * errors.normal();
    const double alpha = truth.on_rim.edges[*truth.on_rim.critical].alpha;
    const auto seen = tipping(input.mass, positions_of(input.contact));
    if (seen.equilibrium != Equilibrium::stable) continue;
    MonteCarloOptions options;
    options.draws = 200;
    options.share_draws = 0;
    const double azimuth = seen.edges[*seen.critical].azimuth_deg;
    const auto result = tipping_draws(
        input, options, [seed](std::uint64_t k) { return base::Random(seed, "draws", k); }, std::span(&azimuth, 1),
        azimuth);
    const auto* q = result.summary.find("alpha_min_deg");
    ASSERT_NE(q, nullptr);
    ++standing;
    const double truth_deg = base::rad_to_deg(alpha);
    covered += q->p05 <= truth_deg && truth_deg <= q->p95 ? 1 : 0;
    below += truth_deg < q->p05 ? 1 : 0;
    width += q->p95 - q->p05;
    bias += q->p50 - truth_deg;
  }
  ASSERT_GT(standing, 120);
  const double share = static_cast<double>(covered) / standing;
  std::printf("%d rocks: covered %.3f, truth below %.3f, mean width %.2f deg, mean of median - truth %.2f deg\n",
              standing, share, static_cast<double>(below) / standing, width / standing, bias / standing);
  EXPECT_GE(share, 0.85);
  EXPECT_LE(share, 0.97);  // 0.90 + 3 standard errors of 150 rocks
}

}  // namespace
}  // namespace cairn::fragility
