#include "fragility/monte_carlo.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/angle.hpp"
#include "base/parallel.hpp"
#include "fragility/contact_noise.hpp"
#include "fragility/draw_summary.hpp"
#include "fragility/subjects.hpp"
#include "fragility/surface_moments.hpp"
#include "fragility/tipping.hpp"
#include "support/bodies.hpp"

namespace cairn::fragility {
namespace {

using namespace cairn::testing;
using base::deg_to_rad;

constexpr double kExact = 1e-9;

MonteCarloOptions nothing_uncertain(std::int64_t draws) {
  MonteCarloOptions o;
  o.draws = draws;
  o.contact_sigma_m = 1e-12;
  o.inferred_sigma_share = 0.0;
  o.bearing_inset_max = 0.0;
  o.cap_sigma_m = 1e-12;
  o.unseen_sigma_share = 0.0;
  o.density_sigma = o.density_gradient = o.vertical_sigma_deg = o.scale_sigma = 0.0;
  return o;
}

// A block whose centre of mass lies nearer to its eastern edge, so that one edge is critical in every draw.
struct LeaningBlock {
  TriangleMesh mesh = prism({{-.5, -1}, {.5, -1}, {.5, 1}, {-.5, 1}}, 3, {0.3, 0});
  MonteCarloInput input;
  LeaningBlock() {
    input.mesh = &mesh;
    input.mass = geometry::mass_properties(mesh);
    input.contact = closed_pad({{-.5, -1, 0}, {.5, -1, 0}, {.5, 1, 0}, {-.5, 1, 0}});
  }
  [[nodiscard]] MonteCarloResult draw(const MonteCarloOptions& options) const {
    const double azimuth = 90.0;
    return tipping_draws(input, options, draw_random, std::span(&azimuth, 1), azimuth);
  }
  [[nodiscard]] double alpha() const {
    const auto result = tipping(input.mass, positions_of(input.contact));
    return result.edges[*result.critical].alpha;
  }
};

double deviation(const std::vector<TippingDraw>& draws, double (*value)(const TippingDraw&)) {
  double sum = 0.0, squares = 0.0;
  for (const auto& d : draws) sum += value(d);
  const double mean = sum / static_cast<double>(draws.size());
  for (const auto& d : draws) squares += (value(d) - mean) * (value(d) - mean);
  return std::sqrt(squares / static_cast<double>(draws.size() - 1));
}

constexpr std::int64_t kMany = 2000;
constexpr double kSampling = 0.06;  // relative: 4 standard errors of a standard deviation of 2000 draws

TEST(MonteCarlo, WithoutUncertaintyEveryDrawIsTheNominal) {
  const LeaningBlock block;
  const auto result = block.draw(nothing_uncertain(20));
  ASSERT_EQ(result.draws.size(), 20U);
  for (const auto& d : result.draws) {
    ASSERT_TRUE(d.standing);
    EXPECT_NEAR(d.alpha, block.alpha(), kExact);
    EXPECT_NEAR(d.mass.volume, 6.0, kExact);
    EXPECT_NEAR((d.mass.inertia_per_density - block.input.mass.inertia_per_density).norm(), 0.0, 1e-8);
    ASSERT_TRUE(d.alpha_bearing);
    EXPECT_NEAR(*d.alpha_bearing, d.alpha, kExact);
  }
  EXPECT_EQ(result.summary.standing, 20);
  // All towards 90 deg, on the border of two sectors.
  EXPECT_NEAR(result.summary.rose.at(8) + result.summary.rose.at(9), 1.0, kExact);
  EXPECT_NEAR(result.critical_share.at(0), 1.0, kExact);
}

// One degree of tilt is one degree of alpha.
TEST(MonteCarlo, VerticalAlone) {
  const LeaningBlock block;
  auto options = nothing_uncertain(kMany);
  options.vertical_sigma_deg = 0.5;
  const auto result = block.draw(options);
  EXPECT_NEAR(deviation(result.draws, [](const TippingDraw& d) { return d.alpha; }), deg_to_rad(0.5),
              kSampling * deg_to_rad(0.5));
  EXPECT_NEAR(deviation(result.draws, [](const TippingDraw& d) { return d.r; }), 0.0, kExact);
  ASSERT_EQ(result.summary.variance_shares.size(), 7U);
  for (const auto& share : result.summary.variance_shares)
    EXPECT_NEAR(share.value, share.name == "vertical" ? 1.0 : 0.0, 1e-6) << share.name;
}

TEST(MonteCarlo, DensityAndScaleLeaveTheAngle) {
  const LeaningBlock block;
  auto options = nothing_uncertain(kMany);
  options.density_sigma = 0.04;
  options.scale_sigma = 0.01;
  const auto result = block.draw(options);
  const double r = result.draws.front().r;
  EXPECT_NEAR(deviation(result.draws, [](const TippingDraw& d) { return d.alpha; }), 0.0, kExact);
  EXPECT_NEAR(deviation(result.draws, [](const TippingDraw& d) { return d.density_kg_m3; }), 0.04 * 2600,
              kSampling * 0.04 * 2600);
  EXPECT_NEAR(deviation(result.draws, [](const TippingDraw& d) { return d.r; }), 0.01 * r, 2 * kSampling * 0.01 * r);
  for (const auto& d : result.draws) {  // R as the scale, V_min as its root, volume as its cube
    const double s = std::cbrt(d.mass.volume / 6.0);
    const auto nominal = tipping(block.input.mass, positions_of(block.input.contact));
    EXPECT_NEAR(d.r, s * nominal.edges[*nominal.critical].r, kExact);
    EXPECT_NEAR(d.v_min, std::sqrt(s) * nominal.edges[*nominal.critical].v_min, kExact);
  }
}

// A gradient over the body moves the centre of mass by C g / V: s times the radius of gyration along each axis.
TEST(MonteCarlo, DensityGradientMovesTheCentre) {
  const LeaningBlock block;
  auto options = nothing_uncertain(kMany);
  options.density_gradient = 0.02;
  const auto result = block.draw(options);
  const double along_y = 2.0 / std::sqrt(12.0);  // radius of gyration of a side of 2 m
  EXPECT_NEAR(deviation(result.draws, [](const TippingDraw& d) { return d.mass.centre_of_mass.y(); }), 0.02 * along_y,
              kSampling * 0.02 * along_y);
}

// Standard deviation of the common part of the line; the critical edge moves with it.
TEST(MonteCarlo, ContactAlone) {
  const LeaningBlock block;
  auto options = nothing_uncertain(kMany);
  options.contact_sigma_m = 0.02;
  options.contact_common_share = 1.0;
  options.contact_vertical_share = 0.0;
  const auto result = block.draw(options);
  // Outwards all round by the same distance: the edge at x = 0.5 moves by that much, a little less where the line turns
  // the corner. d alpha = dx cos(alpha) / R.
  const auto nominal = tipping(block.input.mass, positions_of(block.input.contact));
  const Edge& e = nominal.edges[*nominal.critical];
  const double expected = 0.02 * std::cos(e.alpha) / e.r;
  EXPECT_NEAR(deviation(result.draws, [](const TippingDraw& d) { return d.alpha; }), expected, 0.25 * expected);
  double shares = 0.0;
  for (const auto& s : result.summary.variance_shares) shares += s.value;
  EXPECT_NEAR(shares, 1.0, kExact);
  EXPECT_GT(result.summary.variance_shares.at(0).value, 0.99);
}

TEST(MonteCarlo, NoiseHasUnitVarianceAndIsCorrelatedAlongTheLine) {
  const auto contact = densified(closed_pad({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}), 0.05, 1000);
  const double correlation = 0.2;
  const ContactNoise noise(contact, correlation, 0.0);
  double variance = 0.0, near = 0.0, far = 0.0;
  constexpr std::uint64_t kDraws = 4000;
  for (std::uint64_t k = 0; k < kDraws; ++k) {
    auto random = draw_random(k);
    const auto draw = noise.draw(random);
    variance += draw.out[0] * draw.out[0];
    near += draw.out[0] * draw.out[4];  // 0.2 m along the line
    far += draw.out[0] * draw.out[30];  // 1.5 m
  }
  constexpr double kNoise = 0.08;
  EXPECT_NEAR(variance / kDraws, 1.0, kNoise);
  EXPECT_NEAR(near / kDraws, std::exp(-0.5), kNoise);
  EXPECT_NEAR(far / kDraws, 0.0, kNoise);
}

// First-order answer to a displaced surface against the body displaced for good.
TEST(SurfaceMoments, AgreeWithADisplacedBall) {
  const double r = 1.0, step = 1e-4;
  const auto mesh = truncated_ellipsoid(r, r, r, 0.999, 128);
  const auto mass = geometry::mass_properties(mesh);
  auto larger = mesh;
  for (auto& v : larger.vertices) v *= 1.0 + step;  // radially, so along the normal
  auto moments = moments_of(mass);
  for (const auto& patch : surface_patches(mesh, mass.centre_of_mass, 0.3, {})) moments.add(step, patch);
  const auto linear = mass_of(moments, mass.centre_of_mass, mass.area), exact = geometry::mass_properties(larger);
  constexpr double kSecondOrder = 2e-3;  // of the change: step and facets
  EXPECT_NEAR((linear.volume - mass.volume) / (exact.volume - mass.volume), 1.0, kSecondOrder);
  const double change = exact.inertia_per_density(0, 0) - mass.inertia_per_density(0, 0);
  EXPECT_NEAR((linear.inertia_per_density(0, 0) - mass.inertia_per_density(0, 0)) / change, 1.0, kSecondOrder);
}

TEST(SurfaceMoments, CapOfACircle) {
  std::vector<Vec3> ring;
  for (const auto& p : regular_polygon(720, 0.4)) ring.emplace_back(p.x() + 3.0, p.y(), 1.0);
  const auto cap = cap_moments(closed_pad(ring), {3.0, 0.0, 2.0});
  const double area = std::numbers::pi * 0.16;
  constexpr double kPolygon = 1e-4;
  EXPECT_NEAR(cap.level.area, area, kPolygon);
  EXPECT_NEAR(cap.bump.area, area / 2.0, kPolygon);  // paraboloid over a disc
  EXPECT_NEAR(cap.bump_squared, area / 3.0, kPolygon);
  EXPECT_NEAR(cap.bump.first.z(), -area / 2.0, kPolygon);
  EXPECT_NEAR(cap.bump.first.x(), 0.0, kPolygon);
  std::reverse(ring.begin(), ring.end());
  EXPECT_NEAR(cap_moments(closed_pad(ring), {3.0, 0.0, 2.0}).bump.area, area / 2.0, kPolygon);
}

TEST(MonteCarlo, NeitherThreadsNorTheCountOfDrawsChangeADraw) {
  const LeaningBlock block;
  MonteCarloOptions options;
  options.draws = 40;
  options.contact_sigma_m = 0.02;
  const auto run = [&](int threads, std::int64_t draws) {
    const base::ThreadLimit limit(threads);
    options.draws = draws;
    return block.draw(options);
  };
  const auto one = run(1, 40), two = run(2, 40), fewer = run(2, 7);
  for (std::size_t k = 0; k < 40; ++k) {
    EXPECT_EQ(one.draws[k].alpha, two.draws[k].alpha);
    EXPECT_EQ(one.draws[k].mass.volume, two.draws[k].mass.volume);
    EXPECT_EQ(one.draws[k].mass.inertia_per_density, two.draws[k].mass.inertia_per_density);
    if (k < 7) {
      EXPECT_EQ(one.draws[k].alpha, fewer.draws[k].alpha);
    }
  }
  for (std::size_t s = 0; s < one.summary.variance_shares.size(); ++s)
    EXPECT_EQ(one.summary.variance_shares[s].value, two.summary.variance_shares[s].value);
  EXPECT_EQ(one.summary.a_qs_g_by_azimuth, two.summary.a_qs_g_by_azimuth);
}

// The hidden bearing lies inside the rim: it can only be weaker.
TEST(MonteCarlo, HiddenBearingLowersAlpha) {
  const LeaningBlock block;
  MonteCarloOptions options;
  options.draws = 200;
  const auto result = block.draw(options);
  constexpr double kInclined = 1e-3;  // rad: of inclined edges alpha and a_qs need not rank alike
  for (const auto& d : result.draws) {
    ASSERT_TRUE(d.standing);
    EXPECT_GE(d.bearing_inset, 0.0);
    EXPECT_LE(d.bearing_inset, options.bearing_inset_max);
    if (d.alpha_bearing) {
      EXPECT_LE(*d.alpha_bearing, d.alpha + kInclined);
    }
  }
  ASSERT_NE(result.summary.find("alpha_bearing_deg"), nullptr);
  EXPECT_LT(result.summary.find("alpha_bearing_deg")->p50, result.summary.find("alpha_min_deg")->p50);
}

// Draws that fall over are counted, not averaged in as zeros.
TEST(MonteCarlo, DrawsThatDoNotStand) {
  LeaningBlock block;
  for (auto& v : block.input.contact)
    if (v.position.x() > 0) v.position.x() = block.input.mass.centre_of_mass.x() + 0.01;
  auto options = nothing_uncertain(500);
  options.contact_sigma_m = 0.02;
  options.contact_common_share = 1.0;
  const auto result = block.draw(options);
  EXPECT_GT(result.summary.standing, 200);
  EXPECT_LT(result.summary.standing, 450);
  EXPECT_GT(result.summary.find("alpha_min_deg")->p05, 0.0);
  for (const auto& d : result.draws)
    if (!d.standing) {
      EXPECT_EQ(d.alpha, 0.0);
    }
}

TEST(MonteCarlo, UnseenStretchesAreLessCertain) {
  LeaningBlock block;
  for (auto& v : block.input.contact) v.observed = v.position.x() < 0;
  block.input.contact = densified(block.input.contact, 0.1, 1000);
  block.input.point_spacing_m = 0.01;
  const auto sigmas = contact_sigmas(block.input, {});
  double seen = 0.0, unseen = 0.0;
  for (std::size_t i = 0; i < sigmas.size(); ++i)
    (block.input.contact[i].observed ? seen : unseen) =
        std::max(block.input.contact[i].observed ? seen : unseen, sigmas[i]);
  EXPECT_NEAR(seen, 0.01, kExact);
  EXPECT_GT(unseen, 0.1);
  // Stated: taken as it is where the line was seen; a closure is less certain the farther it lies from what was seen.
  for (auto& v : block.input.contact) v.sigma_m = 0.003;
  const auto stated = contact_sigmas(block.input, {});
  for (std::size_t i = 0; i < stated.size(); ++i) {
    if (block.input.contact[i].observed) {
      EXPECT_EQ(stated[i], 0.003);
    } else {
      EXPECT_GT(stated[i], 0.003);
    }
  }
  for (auto& v : block.input.contact) v.sigma_m = 0.0;
  const auto result = block.draw({});
  double inferred = 0.0;
  for (const auto& s : result.summary.variance_shares)
    if (s.name == "contact_inferred") inferred = s.value;
  EXPECT_GT(inferred, 0.5);
}

TEST(Quantiles, LinearBetweenOrderStatistics) {
  std::vector<double> values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  const auto never = quantiles({1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()});
  EXPECT_EQ(never.p50, std::numeric_limits<double>::infinity());
  EXPECT_EQ(never.p95, std::numeric_limits<double>::infinity());
  const auto q = quantiles(values);
  EXPECT_NEAR(q.p05, 5, kExact);
  EXPECT_NEAR(q.p16, 16, kExact);
  EXPECT_NEAR(q.p50, 50, kExact);
  EXPECT_NEAR(q.p84, 84, kExact);
  EXPECT_NEAR(q.p95, 95, kExact);
  EXPECT_EQ(quantiles({7.0}).p05, 7.0);
}

// Azimuths either side of north do not average to south.
TEST(Quantiles, AzimuthIsUnwrappedAboutTheNominal) {
  std::vector<TippingDraw> draws(10);
  for (std::size_t k = 0; k < 10; ++k) {
    draws[k].standing = true;
    draws[k].azimuth_deg = k % 2 == 0 ? 359.0 : 1.0;
  }
  const auto summary = summary_of(draws, 358.0, 0.65);
  EXPECT_NEAR(summary.find("azimuth_deg")->p05, 359.0, kExact);
  EXPECT_NEAR(summary.find("azimuth_deg")->p95, 361.0, kExact);
}

}  // namespace
}  // namespace cairn::fragility
