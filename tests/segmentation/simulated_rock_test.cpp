#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "segmentation/rock_patch.hpp"
#include "support/rock_scan.hpp"

namespace cairn::segmentation {
namespace {

using geometry::Vec3;

double rock_iou(std::span<const Label> found, std::span<const std::uint8_t> truth) {
  double both = 0, any = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (found[i] == Label::basal_contact) continue;  // lies on either
    const bool is = truth[i] == static_cast<std::uint8_t>(Label::rock), said = found[i] == Label::rock;
    both += is && said;
    any += is || said;
  }
  return both / any;
}

// Rocks of three families as a close-range survey sees them; the table over many seeds stands in the docs.
class SimulatedRock : public ::testing::TestWithParam<std::pair<const char*, std::uint64_t>> {};

TEST_P(SimulatedRock, IsFoundWithItsContact) {
  testing::RockScanOptions options;
  options.family = GetParam().first;
  options.height_m = 0.9;
  options.hiding = testing::Hiding::none;
  const auto scan = testing::make_rock_scan(GetParam().second, options);
  PatchInput in;
  in.points = scan.cloud.positions;
  in.centre = scan.cylinder.axis;
  in.radius = scan.cylinder.radius;
  const auto result = segment_patch(in, {});
  ASSERT_TRUE(result.found()) << result.reason;
  EXPECT_GT(rock_iou(result.labels, scan.surface), 0.93);
  double off = 0.0;
  for (const auto& v : result.contact) {
    double nearest = 1e300;
    for (const Vec3& p : scan.rim.front()) nearest = std::min(nearest, (p - v.position).norm());
    off += nearest / static_cast<double>(result.contact.size());
  }
  EXPECT_LT(off, 3.0 * scan.spacing_m);
}

INSTANTIATE_TEST_SUITE_P(Families, SimulatedRock,
                         ::testing::Values(std::pair("rounded", 101), std::pair("pear", 102),
                                           std::pair("angular", 106)));

}  // namespace
}  // namespace cairn::segmentation
