#include "fragility/contact_line.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "fragility/assessment.hpp"
#include "fragility/polar_plot.hpp"
#include "fragility/subjects.hpp"
#include "support/bodies.hpp"

namespace cairn::fragility {
namespace {

using namespace cairn::testing;

// A 2 x 1 rectangle, its short side from (2,0) to (2,1) inferred at one end.
std::vector<ContactVertex> rectangle(bool closed) {
  return {{0, 3, {0, 1, 0}, true, closed},
          {0, 1, {2, 0, 0}, true, closed},
          {0, 0, {0, 0, 0}, true, closed},
          {0, 2, {2, 1, 0}, false, closed}};
}

TEST(ContactLine, ShareByLength) {
  auto ring = rectangle(true);
  sort_contact(ring);
  EXPECT_EQ(ring[1].position.x(), 2);
  EXPECT_NEAR(observed_share(ring), 3.0 / 6.0, 1e-12);
  auto open = rectangle(false);
  sort_contact(open);
  EXPECT_NEAR(observed_share(open), 2.0 / 5.0, 1e-12);
  EXPECT_EQ(observed_share({}), 0.0);
}

TEST(ContactLine, PadsAreApart) {
  std::vector<ContactVertex> pads = {{1, 0, {0, 0, 0}, true, false},
                                     {1, 1, {1, 0, 0}, true, false},
                                     {2, 0, {9, 0, 0}, false, false},
                                     {2, 1, {9, 1, 0}, false, false}};
  EXPECT_NEAR(observed_share(pads), 0.5, 1e-12);
}

TEST(ContactLine, OutsideTheRock) {
  auto ring = rectangle(true);
  geometry::Box3 box;
  box.extend({0, 0, 0});
  box.extend({1.5, 1, 2});
  EXPECT_EQ(outside_count(ring, box, 0.1), 2U);
  EXPECT_EQ(outside_count(ring, box, 0.6), 0U);
}

TEST(PolarPlot, DrawsAndRefuses) {
  Evidence evidence;
  evidence.contact_assumed = false;
  evidence.contact_observed_share = 1;
  const auto contact = contact_band(block(1, 1, 3), 0.02);
  const auto good = assess_points(exact_block(1, 1, 3), contact, evidence, {});
  const auto svg = polar_plot_svg(good.tipping, "rock <4>");
  EXPECT_EQ(svg.rfind("<svg", 0), 0U);
  EXPECT_NE(svg.find("rock &lt;4&gt;"), std::string::npos);
  EXPECT_NE(svg.find("18.4 deg"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_THROW((void)polar_plot_svg({}, "none"), base::Error);
}

}  // namespace
}  // namespace cairn::fragility
