#include "fragility/grade.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "fragility/assessment.hpp"
#include "fragility/subjects.hpp"
#include "support/bodies.hpp"

namespace cairn::fragility {
namespace {

using namespace cairn::testing;
using survey::Grade;
using ::testing::Contains;
using ::testing::IsEmpty;

Evidence complete() {
  Evidence e;
  e.points = 20000;
  e.point_spacing_m = 0.01;
  e.width_m = 1.0;
  e.height_m = 1.5;
  e.unseen_area_fraction = 0.1;
  e.sides_seen_share = 1.0;
  e.contact_assumed = false;
  e.contact_observed_share = 0.95;
  return e;
}

TEST(Grade, EveryRungHasItsReason) {
  const GradeOptions options;
  EXPECT_EQ(grade(complete(), options).grade, Grade::measured);
  EXPECT_THAT(grade(complete(), options).reasons, IsEmpty());

  const auto expect = [&](auto change, Grade expected, const char* reason) {
    Evidence e = complete();
    change(e);
    const auto g = grade(e, options);
    EXPECT_EQ(g.grade, expected) << reason;
    EXPECT_THAT(g.reasons, Contains(reason));
  };
  expect([](Evidence& e) { e.contact_assumed = true; }, Grade::screening, "contact_assumed");
  expect([](Evidence& e) { e.contact_observed_share = 0.7; }, Grade::bounded, "contact_partly_seen");
  expect([](Evidence& e) { e.contact_observed_share = 0.3; }, Grade::screening, "contact_partly_seen");
  expect([](Evidence& e) { e.points = 35; }, Grade::not_measurable, "too_few_points");
  expect([](Evidence& e) { e.point_spacing_m = 0.2; }, Grade::not_measurable, "too_coarse");
  expect([](Evidence& e) { e.point_spacing_m = 0.05; }, Grade::bounded, "too_coarse");
  expect([](Evidence& e) { e.sides_seen_share = 0.2; }, Grade::not_measurable, "sides_not_seen");
  expect([](Evidence& e) { e.unseen_area_fraction = 0.7; }, Grade::not_measurable, "mostly_unseen");
  expect([](Evidence& e) { e.unseen_area_fraction = 0.5; }, Grade::screening, "partly_unseen");
  expect([](Evidence& e) { e.unseen_area_fraction = 0.2; }, Grade::bounded, "partly_unseen");
  expect([](Evidence& e) { e.unseen_area_fraction.reset(); }, Grade::bounded, "surface_evidence_unknown");
}

TEST(Grade, AssumedContactIsScreeningAtBest) {
  Evidence e = complete();
  e.contact_assumed = true;
  e.contact_observed_share = 1.0;
  EXPECT_EQ(grade(e, {}).grade, Grade::screening);
}

TEST(Assessment, NotMeasurableCarriesNoAngleAnywhere) {
  const auto mass = exact_block(1, 1, 3);
  const auto contact = contact_band(block(1, 1, 3), 0.02);
  ASSERT_EQ(contact.size(), 4U);
  Evidence e = complete();
  e.points = 20;
  const auto result = assess_points(mass, contact, e, {});
  EXPECT_EQ(result.tipping.grade, Grade::not_measurable);
  EXPECT_FALSE(result.tipping.critical);
  EXPECT_TRUE(result.tipping.a_qs_g_by_azimuth.empty());
  EXPECT_TRUE(result.detail.edges.empty());
  EXPECT_TRUE(result.detail.a_qs_g_by_azimuth.empty());
  EXPECT_EQ(result.detail.a_qs_min_g, 0.0);
  EXPECT_EQ(result.detail.alpha_point, 0.0);
  EXPECT_EQ(result.tipping.contact.size(), 4U);
}

TEST(Assessment, PlumbPointOutsideIsNamed) {
  const std::vector<Vec3> contact = {{.2, -.5, 0}, {.5, -.5, 0}, {.5, .5, 0}, {.2, .5, 0}};
  const auto result = assess_points(exact_block(1, 1, 3), contact, complete(), {});
  EXPECT_EQ(result.tipping.grade, Grade::not_measurable);
  EXPECT_THAT(result.tipping.reasons, Contains("not_in_equilibrium"));
  EXPECT_FALSE(result.tipping.critical);
}

TEST(Assessment, MeasuredBlockAndSlidingSlab) {
  const std::vector<Vec3> contact = {{-.5, -.5, 0}, {.5, -.5, 0}, {.5, .5, 0}, {-.5, .5, 0}};
  const auto slender = assess_points(exact_block(1, 1, 3), contact, complete(), {});
  EXPECT_EQ(slender.tipping.grade, Grade::measured);
  ASSERT_TRUE(slender.tipping.critical);
  EXPECT_NEAR(slender.tipping.critical->a_qs_g, 1.0 / 3.0, 1e-12);
  EXPECT_EQ(slender.tipping.a_qs_g_by_azimuth.size(), 360U);
  EXPECT_THAT(slender.tipping.reasons, IsEmpty());
  const auto slab = assess_points(exact_block(1, 1, 1), contact, complete(), {});
  EXPECT_THAT(slab.tipping.reasons, Contains("slides_first"));
}

TEST(FragilityOptions, RangesAreChecked) {
  FragilityOptions options;
  EXPECT_NO_THROW(base::validate(base::bind_options(options), "fragility"));
  options.density_kg_m3 = -1;
  EXPECT_THROW(base::validate(base::bind_options(options), "fragility"), std::exception);
}

}  // namespace
}  // namespace cairn::fragility
