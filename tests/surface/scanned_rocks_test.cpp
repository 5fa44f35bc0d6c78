// Simulated close-range scans of rocks on pedestals: volume and centre of mass against the truth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "support/rock_scan.hpp"
#include "surface/rock_body.hpp"

namespace cairn::surface {
namespace {

using geometry::Vec3;

RockBody body_of_scan(const testing::RockScan& scan) {
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < scan.cloud.size(); ++i)
    if (scan.surface[i] == 2) points.push_back(scan.cloud.positions[i]);
  const BodyInput input{points, [&](const geometry::Vec2&) { return scan.cylinder.bottom; }, scan.spacing_m, 1.0,
                        scan.contact()};
  auto built = build_body(input, {});
  if (const auto* why = std::get_if<base::Reject>(&built)) {
    ADD_FAILURE() << scan.seed << " " << why->reason << ": " << why->message;
    return {};
  }
  return std::get<RockBody>(std::move(built));
}

TEST(ScannedRocks, VolumeAndCentreOfMass) {
  // Figures wanted of 200 rocks: median of |error| at most 2 %. On these: 0.3 %, the worst 2 % where a third of the
  // flank is hidden.
  constexpr double kMedian = 0.01, kWorst = 0.04, kMean = 0.01;
  std::vector<double> errors;
  for (std::uint64_t seed = 1; seed <= 9; ++seed) {
    testing::RockScanOptions options;
    options.height_m = 0.9;
    if (seed > 7) options.family = testing::kHeldOutFamily;
    const auto scan = testing::make_rock_scan(seed, options);
    const auto body = body_of_scan(scan);
    EXPECT_EQ(body.method, "implicit");
    EXPECT_EQ(body.cap, survey::CapModel::patch);
    EXPECT_FALSE(body.contact_assumed);
    EXPECT_TRUE(body.quality.watertight);
    EXPECT_NEAR(body.noise, scan.noise_m, 0.25 * scan.noise_m);
    EXPECT_NEAR(body.point_spacing, scan.spacing_m, 0.25 * scan.spacing_m);
    EXPECT_GT(body.cap_height_sigma, scan.spacing_m);
    errors.push_back(body.mass.volume / scan.mass.volume - 1.0);
    const double size = std::cbrt(scan.mass.volume);
    EXPECT_LT((body.mass.centre_of_mass - scan.mass.centre_of_mass).norm(), 0.03 * size) << seed;
  }
  const double mean = std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  for (auto& e : errors) e = std::abs(e);
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], kMedian);
  EXPECT_LT(errors.back(), kWorst);
  EXPECT_LT(std::abs(mean), kMean);
}

}  // namespace
}  // namespace cairn::surface
